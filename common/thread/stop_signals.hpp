#pragma once

#include <chrono>
#include <csignal>
#include <functional>
#include <initializer_list>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

namespace terravox::thread {

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
