#pragma once

#include <semaphore.h>

#include <chrono>
#include <csignal>

namespace terravox::serve {

/// SIGINT and SIGTERM are held back while this lives, so that threads started meanwhile never see
/// them.
class SignalsHeld {
public:
    SignalsHeld();
    ~SignalsHeld() { pthread_sigmask(SIG_SETMASK, &m_before, nullptr); }
    SignalsHeld(const SignalsHeld&) = delete;
    SignalsHeld& operator=(const SignalsHeld&) = delete;

private:
    sigset_t m_before{};
};

/// They reach this thread while this lives, within a SignalsHeld.
class SignalsLetThrough {
public:
    SignalsLetThrough();
    ~SignalsLetThrough() { pthread_sigmask(SIG_SETMASK, &m_before, nullptr); }
    SignalsLetThrough(const SignalsLetThrough&) = delete;
    SignalsLetThrough& operator=(const SignalsLetThrough&) = delete;

private:
    sigset_t m_before{};
};

/// The first SIGINT or SIGTERM is a wish to stop; a second one of the same kind ends the process as
/// if nothing had been installed.
void install_stop_handlers();

/// Waits for such a wish. @return whether it came in time
[[nodiscard]] bool wait_for_stop(std::chrono::milliseconds longest);

}  // namespace terravox::serve
