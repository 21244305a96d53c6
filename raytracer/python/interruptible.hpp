#pragma once

#include <nanobind/nanobind.h>
#include <terravox/control.hpp>

#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

namespace terravox::python {

namespace nb = nanobind;

/// Threads whose results nobody waits for any more: their calls were interrupted in the middle of a
/// box. They end soon, and must have ended before the interpreter does.
class LeftThreads {
public:
    static LeftThreads& all();
    void add(std::thread thread);
    /// Waits for all of them. To be called without the interpreter's lock.
    void join();

private:
    std::mutex m_mutex;
    std::vector<std::thread> m_threads;
};

/// The progress of a call, from the thread that works to the one that waits.
class SharedProgress {
public:
    using Counts = std::pair<std::uint64_t, std::uint64_t>;
    void set(std::uint64_t done, std::uint64_t total) {
        const std::lock_guard lock(m_mutex);
        m_latest = {done, total};
    }
    [[nodiscard]] std::optional<Counts> take() {
        const std::lock_guard lock(m_mutex);
        return std::exchange(m_latest, std::nullopt);
    }

private:
    std::mutex m_mutex;
    std::optional<Counts> m_latest;
};

/// Runs work(control) on another thread, without the interpreter's lock, so that Ctrl-C and calls
/// of `progress` come through meanwhile. After Ctrl-C or an error in `progress` the call ends at
/// once; the thread ends as soon as what it makes is finished.
/// @param work owns all that it uses, for it may outlive the call
/// @param progress None, or called with two numbers: what is done, and how much there is
template <class Work>
auto interruptible(const nb::object& progress, Work work) {
    using Result = std::invoke_result_t<Work&, const Control&>;
    constexpr std::chrono::milliseconds kPeriod{20};
    const auto shared = std::make_shared<SharedProgress>();
    std::stop_source stop;
    Control control;
    control.stop = stop.get_token();
    if (!progress.is_none())
        control.progress = [shared](std::uint64_t done, std::uint64_t of) {
            shared->set(done, of);
        };
    std::packaged_task<Result()> task(
        [work = std::move(work), control]() mutable { return work(control); });
    std::future<Result> result = task.get_future();
    std::thread thread(std::move(task));
    const auto report = [&] {
        if (const auto counts = shared->take())
            progress(counts->first, counts->second);
    };
    try {
        const nb::gil_scoped_release without_lock;
        while (result.wait_for(kPeriod) != std::future_status::ready) {
            const nb::gil_scoped_acquire with_lock;
            if (PyErr_CheckSignals() != 0)
                throw nb::python_error();
            report();
        }
        thread.join();
    } catch (...) {
        stop.request_stop();
        LeftThreads::all().add(std::move(thread));
        throw;
    }
    report();
    return result.get();
}

}  // namespace terravox::python
