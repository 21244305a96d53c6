#pragma once

#include <chrono>
#include <csignal>
#include <functional>
#include <initializer_list>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "common/util/error.hpp"

namespace terravox::thread {

/// A fetch of a box was cancelled because the box is no longer needed: neither a hole nor an error
/// to report.
class StoppedError : public util::Error {
public:
    using util::Error::Error;
};

/// Whether running work must stop: when a stop is requested on either of two tokens, or at a
/// deadline.
class StopCondition {
public:
    using Clock = std::chrono::steady_clock;
    /// A default-constructed token, which has no source, never requests a stop.
    explicit StopCondition(std::stop_token first, std::stop_token second = {},
                           Clock::time_point deadline = Clock::time_point::max()) noexcept
        : m_first(std::move(first)), m_second(std::move(second)), m_deadline(deadline) {}
    [[nodiscard]] bool is_met() const noexcept {
        return m_first.stop_requested() || m_second.stop_requested() ||
               (m_deadline != Clock::time_point::max() && Clock::now() >= m_deadline);
    }

private:
    std::stop_token m_first;
    std::stop_token m_second;
    Clock::time_point m_deadline;
};

/// RAII: turns signals into a stop request during its lifetime, instead of letting them end the
/// program. Since signal handlers may call next to nothing, a thread waits for the signals. At most
/// one object at a time per process; the previous signal dispositions are restored on destruction.
class StopSignals {
public:
    struct Options {
        std::vector<int> stop{SIGINT, SIGTERM};  ///< signals that request a stop
        /// Whether the second signal of the same kind has its default effect: to end the program at
        /// once.
        bool second_ends_program = false;
        /// Called for each SIGHUP, on the thread of this object; must not throw. Empty: the
        /// disposition of SIGHUP is left unchanged.
        std::function<void()> on_hangup;
    };
    StopSignals() : StopSignals(Options{}) {}
    /// @throws Error when the thread cannot be started
    explicit StopSignals(Options options);
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

    [[nodiscard]] std::stop_token token() const noexcept { return m_stop.get_token(); }

private:
    void watch() noexcept;
    void install(int signal, bool reset);

    std::function<void()> m_on_hangup;
    std::vector<std::pair<int, struct sigaction>> m_before;
    std::stop_source m_stop;
    std::thread m_thread;
};

/// RAII: blocks SIGINT and SIGTERM for the calling thread and for threads started from it during
/// its lifetime, so that none of their calls is interrupted. The thread of a StopSignals still
/// receives them. Must be created and destroyed on the same thread.
class SignalsBlocked {
public:
    SignalsBlocked();
    ~SignalsBlocked() { ::pthread_sigmask(SIG_SETMASK, &m_before, nullptr); }
    SignalsBlocked(const SignalsBlocked&) = delete;
    SignalsBlocked& operator=(const SignalsBlocked&) = delete;

private:
    sigset_t m_before{};
};

/// Waits until a stop is requested, for at most `max_wait`.
/// @return whether a stop was requested
bool wait_for_stop(const std::stop_token& stop, std::chrono::milliseconds max_wait);

}  // namespace terravox::thread
