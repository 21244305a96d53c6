#include "common/thread/stop.hpp"

#include <unistd.h>

#include <array>
#include <atomic>

#include "tests/catch.hpp"

using namespace terravox;
using namespace std::chrono_literals;

namespace {

struct sigaction read_action(int signal) {
    struct sigaction out{};
    ::sigaction(signal, nullptr, &out);
    return out;
}

bool waits_for(const std::atomic<int>& count, int wanted) {
    for (int tries = 0; tries < 6000 && count < wanted; ++tries)
        std::this_thread::sleep_for(10ms);
    return count >= wanted;
}

}  // namespace

TEST_CASE("a signal requests a stop while it is handled, and has its old effect afterwards",
          "[common][thread]") {
    for (const int signal : {SIGINT, SIGTERM}) {
        CAPTURE(signal);
        const auto before = read_action(signal);
        {
            const thread::StopSignals signals;
            CHECK_FALSE(signals.token().stop_requested());
            CHECK_FALSE(thread::wait_for_stop(signals.token(), 1ms));
            ::raise(signal);
            CHECK(thread::wait_for_stop(signals.token(), 10min));
        }
        CHECK(read_action(signal).sa_handler == before.sa_handler);
        const thread::StopSignals again;
        CHECK_FALSE(again.token().stop_requested());
    }
}

// The thread sanitizer hands a signal to any thread of the test program, such as one of oneTBB's
// that sleeps, and runs the handler when that thread next calls something that it intercepts.
#ifndef __SANITIZE_THREAD__
TEST_CASE("a signal that the program's other threads block is received", "[common][thread]") {
    const thread::SignalsBlocked blocked;
    const thread::StopSignals signals;
    ::kill(::getpid(), SIGTERM);
    CHECK(thread::wait_for_stop(signals.token(), 10min));
}
#endif

TEST_CASE("SIGHUP is left alone, requests a stop, or calls the given function",
          "[common][thread]") {
    const auto before = read_action(SIGHUP);
    {
        const thread::StopSignals signals;
        CHECK(read_action(SIGHUP).sa_handler == before.sa_handler);
    }
    {
        const thread::StopSignals signals({{SIGHUP}, false, {}});
        ::raise(SIGHUP);
        CHECK(thread::wait_for_stop(signals.token(), 10min));
    }
    std::atomic<int> calls{0};
    thread::StopSignals::Options options;
    options.on_hangup = [&] { ++calls; };
    const thread::StopSignals signals(options);
    for (int i = 1; i <= 3; ++i) {
        ::raise(SIGHUP);
        CHECK(waits_for(calls, i));
    }
    CHECK_FALSE(signals.token().stop_requested());
}

TEST_CASE("a second signal of one kind has its usual effect where that is wanted",
          "[common][thread]") {
    const thread::StopSignals signals({{SIGINT}, true, {}});
    CHECK(read_action(SIGINT).sa_handler != SIG_DFL);
    ::raise(SIGINT);
    CHECK(thread::wait_for_stop(signals.token(), 10min));
    CHECK(read_action(SIGINT).sa_handler == SIG_DFL);
}
