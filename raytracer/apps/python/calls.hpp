#pragma once

#include <nanobind/nanobind.h>
#include <sys/types.h>
#include <chrono>
#include <condition_variable>
#include <future>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <terravox/control.hpp>
#include <thread>
#include <utility>
#include <vector>

namespace terravox::python {

/// Adds the exceptions Error, a RuntimeError, and UsageError, an Error and a ValueError, and turns
/// those of the library into them.
void add_errors(nanobind::module_& module);

namespace nb = nanobind;

/// All calls that are under way, and the threads of those that were interrupted in the middle of a
/// box. They must have ended before the interpreter does, which ends other threads wherever they
/// ask for its lock.
class Calls {
public:
    static Calls& all();

    /// A call that is under way.
    class Scope {
    public:
        /// @throws Error once the interpreter ends
        explicit Scope(const std::stop_source& stop);
        ~Scope();
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;

    private:
        std::list<std::stop_source>::iterator m_place;
    };

    /// Takes the thread of an interrupted call, whose result is not needed.
    /// @param ended when it is ready, the thread is about to end
    void leave(std::thread thread, std::shared_future<void> ended);
    /// Refuses further calls, stops those that are under way, and waits for all threads. To be
    /// called without the interpreter's lock. In a forked process it does nothing.
    void finish();

private:
    struct LeftThread {
        std::thread thread;
        std::shared_future<void> ended;
    };
    std::mutex m_mutex;
    std::condition_variable m_idle;
    std::list<std::stop_source> m_running;
    std::vector<LeftThread> m_left;
    std::vector<LeftThread>* m_others = nullptr;  ///< of the process that forked; never destroyed
    bool m_closed = false;
    pid_t m_process = 0;  ///< that the threads are in
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
    const Calls::Scope scope(stop);
    Control control;
    control.stop = stop.get_token();
    if (!progress.is_none())
        control.progress = [shared](std::uint64_t done, std::uint64_t of) {
            shared->set(done, of);
        };
    std::promise<void> ended;
    const std::shared_future<void> end = ended.get_future().share();
    std::packaged_task<Result()> task(
        [work = std::move(work), control]() mutable { return work(control); });
    std::future<Result> result = task.get_future();
    std::thread thread([task = std::move(task), ended = std::move(ended)]() mutable {
        task();
        // What it owned, Python's objects among it, is let go before the thread counts as ended.
        task = {};
        ended.set_value();
    });
    const auto report = [&] {
        if (const auto counts = shared->take())
            progress(counts->first, counts->second);
    };
    try {
        const nb::gil_scoped_release without_lock;
        while (end.wait_for(kPeriod) != std::future_status::ready) {
            const nb::gil_scoped_acquire with_lock;
            if (PyErr_CheckSignals() != 0)
                throw nb::python_error();
            report();
        }
        thread.join();
    } catch (...) {
        stop.request_stop();
        Calls::all().leave(std::move(thread), end);
        throw;
    }
    report();
    return result.get();
}

}  // namespace terravox::python
