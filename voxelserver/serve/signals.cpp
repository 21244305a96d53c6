#include "voxelserver/serve/signals.hpp"

#include <cerrno>
#include <ctime>

namespace terravox::serve {
namespace {

sem_t g_stop;  // sem_post is one of the few calls allowed in a signal handler

sigset_t both_signals() noexcept {
    sigset_t out;
    sigemptyset(&out);
    sigaddset(&out, SIGINT);
    sigaddset(&out, SIGTERM);
    return out;
}

}  // namespace

SignalsHeld::SignalsHeld() {
    const sigset_t both = both_signals();
    pthread_sigmask(SIG_BLOCK, &both, &m_before);
}

SignalsLetThrough::SignalsLetThrough() {
    const sigset_t both = both_signals();
    pthread_sigmask(SIG_UNBLOCK, &both, &m_before);
}

void install_stop_handlers() {
    sem_init(&g_stop, 0, 0);
    struct sigaction action{};
    action.sa_handler = [](int) { sem_post(&g_stop); };
    action.sa_flags = static_cast<int>(SA_RESTART | SA_RESETHAND);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

bool wait_for_stop(std::chrono::milliseconds longest) {
    timespec until{};
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec += longest.count() / 1000;
    until.tv_nsec += longest.count() % 1000 * 1'000'000;
    if (until.tv_nsec >= 1'000'000'000) {
        ++until.tv_sec;
        until.tv_nsec -= 1'000'000'000;
    }
    int got = 0;
    while ((got = sem_timedwait(&g_stop, &until)) != 0 && errno == EINTR) {
    }
    return got == 0;
}

}  // namespace terravox::serve
