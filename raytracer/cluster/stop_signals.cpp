#include "raytracer/cluster/stop_signals.hpp"

#include <poll.h>
#include <signal.h>

#include <array>

namespace terravox::cluster {
namespace {

constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};
volatile sig_atomic_t g_came = 0;
std::array<struct sigaction, kSignals.size()> g_before;

}  // namespace

StopSignals::StopSignals() {
    g_came = 0;
    struct sigaction note{};
    note.sa_handler = [](int) { g_came = 1; };
    sigemptyset(&note.sa_mask);
    for (std::size_t i = 0; i < kSignals.size(); ++i)
        ::sigaction(kSignals[i], &note, &g_before[i]);
}

StopSignals::~StopSignals() {
    for (std::size_t i = 0; i < kSignals.size(); ++i)
        ::sigaction(kSignals[i], &g_before[i], nullptr);
}

bool StopSignals::came() noexcept {
    return g_came != 0;
}

bool StopSignals::wait_ms(int max_ms) noexcept {
    // In short steps: one that comes between the question and the wait is seen soon all the same.
    constexpr int kStep_ms = 100;
    for (int waited_ms = 0; waited_ms < max_ms && !came(); waited_ms += kStep_ms)
        ::poll(nullptr, 0, max_ms - waited_ms < kStep_ms ? max_ms - waited_ms : kStep_ms);
    return came();
}

}  // namespace terravox::cluster
