#pragma once

#include <cstdint>
#include <exception>
#include <mutex>
#include <new>
#include <terravox/control.hpp>
#include <terravox/error.hpp>
#include <utility>

#include "common/util/error.hpp"

namespace terravox {

/// Threads do not survive a fork, and would be waited for: the library works in the process in
/// which it first had threads, and in those that were forked before that.
/// @throws util::UsageError in a process that was forked later
void check_process();

/// To be called before threads are made.
/// @throws as check_process()
void note_process();

/// Whether threads of the library that were made are in this process.
[[nodiscard]] bool has_threads_here() noexcept;

/// Sends warnings and errors to standard error, unless set_log_level() has been called.
void set_up_log_once();

/// Counts the finished steps of a call, and reports them to Control::progress. Thread-safe.
class Steps {
public:
    Steps(const Control& control, std::uint64_t total) : m_control(control), m_total(total) {}

    void add_one() {
        const std::lock_guard lock(m_mutex);
        ++m_done;
        if (m_control.progress)
            m_control.progress(m_done, m_total);
    }

private:
    const Control& m_control;
    const std::uint64_t m_total;
    std::mutex m_mutex;
    std::uint64_t m_done = 0;
};

/// Calls work() where the library can be used, and turns all errors but missing
/// memory into those that its users know.
template <class Work>
decltype(auto) guarded(Work&& work) {
    try {
        check_process();
        return std::forward<Work>(work)();
    } catch (const Error&) {
        throw;
    } catch (const util::UsageError& e) {
        throw UsageError(e.what());
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        throw Error(e.what());
    }
}

/// The same for a call that its caller may stop: it then ends with Stopped, whatever has failed.
template <class Work>
decltype(auto) guarded(const Control& control, Work&& work) {
    try {
        return guarded(std::forward<Work>(work));
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const Error&) {
        if (control.stop.stop_requested())
            throw Stopped("stopped");
        throw;
    }
}

}  // namespace terravox
