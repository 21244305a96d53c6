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

/// Turns signals into a stop request while it lives, instead of ending the program by them. A
/// signal's handler may call next to nothing, so a thread waits for signals here. One object at a
/// time in a process; what was done at a signal before is done again afterwards.
class StopSignals {
public:
    struct Options {
        std::vector<int> stop{SIGINT, SIGTERM};  ///< these ask to stop
        /// The second signal of the same kind has its usual effect: it ends the program at once.
        bool second_ends_program = false;
        /// Called for each SIGHUP, on the thread of this object, and must not throw; empty: SIGHUP
        /// is left alone.
        std::function<void()> on_hangup;
    };
    StopSignals() : StopSignals(Options{}) {}
    /// @throws Error without a thread
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

/// The calling thread, and threads that are started from it meanwhile, do not see SIGINT and
/// SIGTERM while this lives: no call of theirs is interrupted by one. The thread of a StopSignals
/// does. Made and ended by one thread.
class SignalsBlocked {
public:
    SignalsBlocked();
    ~SignalsBlocked() { ::pthread_sigmask(SIG_SETMASK, &m_before, nullptr); }
    SignalsBlocked(const SignalsBlocked&) = delete;
    SignalsBlocked& operator=(const SignalsBlocked&) = delete;

private:
    sigset_t m_before{};
};

/// Waits until the token is stopped, but no longer than this. @return whether it is stopped
bool wait_for_stop(const std::stop_token& stop, std::chrono::milliseconds longest);

}  // namespace terravox::thread
