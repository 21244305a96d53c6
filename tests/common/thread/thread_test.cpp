#include <sched.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <atomic>
#include <memory>
#include <new>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "common/thread/in_order.hpp"
#include "common/thread/parallel.hpp"
#include "common/thread/start_threads.hpp"
#include "common/thread/stop.hpp"
#include "tests/catch.hpp"
#include "tests/common/child_process.hpp"
#include "tests/common/emulated.hpp"

using namespace terravox::thread;
using namespace terravox;
using namespace std::chrono_literals;

namespace {

/// Fails when it is copied for the thread after `allowed` others, as a thread fails that the system
/// refuses.
struct Work {
    std::atomic<int>* copies;
    int allowed;
    std::atomic<int>* ended;
    std::stop_token stopped;

    Work(std::atomic<int>* copy_count, int allowed_copies, std::atomic<int>* ended_count,
         std::stop_token token)
        : copies(copy_count),
          allowed(allowed_copies),
          ended(ended_count),
          stopped(std::move(token)) {}
    Work(const Work& other) : Work(other.copies, other.allowed, other.ended, other.stopped) {
        if (copies->fetch_add(1) >= allowed) {
            throw std::system_error(
                std::make_error_code(std::errc::resource_unavailable_try_again));
        }
    }
    void operator()() const {
        while (!stopped.stop_requested())
            std::this_thread::yield();
        ++*ended;
    }
};

int refused() {
    throw std::logic_error("the system has threads");
}

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

TEST_CASE("parallel work is done once for each index, with any number of threads",
          "[common][thread]") {
    const int threads = GENERATE(0, 1, 2, 7);
    const std::size_t count = GENERATE(std::size_t{0}, std::size_t{1}, std::size_t{1000});
    INFO(threads << " threads, " << count << " indices");
    std::vector<std::atomic<int>> done(count);
    parallel_for(count, threads, [&](std::size_t i) { ++done[i]; });
    int wrong = 0;
    for (const auto& times : done)
        wrong += times != 1;
    CHECK(wrong == 0);
}

TEST_CASE("what parallel work throws arrives with its type", "[common][thread]") {
    CHECK_THROWS_AS(parallel_for(100, 2,
                                 [](std::size_t i) {
                                     if (i == 42)
                                         throw std::out_of_range("42");
                                 }),
                    std::out_of_range);
}

// Of the sanitizers, their own memory would be refused, too.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_CASE("without memory for tasks a new thread's work ends with an error", "[common][thread]") {
    if (terravox::test::emulated()) {
        WARN("not tried: the emulator would be without memory, too");
        return;
    }
    const bool in_order_too = GENERATE(false, true);
    const terravox::test::ChildEnd end = terravox::test::run_in_child([&] {
        std::thread([&] {
            const rlimit none_left{1, 1};
            ::setrlimit(RLIMIT_AS, &none_left);
            if (in_order_too)
                in_order(2, 2, [](std::size_t i) { return i; }, [](std::size_t, std::size_t) {});
            else
                parallel_for(2, 2, [](std::size_t) {});
        }).join();
    });
    CHECK(WIFEXITED(end.status));
    CHECK(WEXITSTATUS(end.status) == 1);
    CHECK(end.error_output ==
          "terravox: out of memory; lower memory limits or a smaller task may help\n");
}
#endif

TEST_CASE("a thread count of zero means all cores that may be used", "[common][thread]") {
    // On a thread of its own, so that the others keep their cores.
    std::thread([] {
        cpu_set_t cores;
        REQUIRE(::sched_getaffinity(0, sizeof cores, &cores) == 0);
        int first = 0;
        while (!CPU_ISSET(first, &cores))
            ++first;
        CPU_ZERO(&cores);
        CPU_SET(first, &cores);
        REQUIRE(::sched_setaffinity(0, sizeof cores, &cores) == 0);
        CHECK(thread_count(0) == 1);
        CHECK(task_thread_count(4) == 1);
        CHECK(thread_count(4) == 4);
    }).join();
    CHECK(thread_count(0) >= 1);
    CHECK(thread_count(-3) >= 1);
    CHECK(thread_count(5) == 5);
    CHECK(task_thread_count(1) == 1);
    CHECK(task_thread_count(1000) == thread_count(0));
}

TEST_CASE("what threads make is used in order, each once, few at a time", "[common][thread]") {
    for (const int threads : {1, 2, 7}) {
        for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{500}}) {
            INFO(threads << " threads, " << count << " things");
            std::vector<std::size_t> used;
            std::atomic<int> waiting{0};
            std::atomic<int> most{0};
            thread::in_order(
                count, threads,
                [&](std::size_t i) {
                    const int now = ++waiting;
                    for (int seen = most; now > seen && !most.compare_exchange_weak(seen, now);) {
                    }
                    return std::to_string(i);
                },
                [&](std::size_t i, const std::string& made) {
                    CHECK(made == std::to_string(i));
                    used.push_back(i);
                    --waiting;
                });
            REQUIRE(used.size() == count);
            for (std::size_t i = 0; i < count; ++i)
                CHECK(used[i] == i);
            CHECK(most <= 2 * threads);
        }
    }
}

TEST_CASE("what making or using throws comes out", "[common][thread]") {
    const auto nothing = [](std::size_t, int) {};
    CHECK_THROWS_AS(
        thread::in_order(
            100, 3, [](std::size_t i) { return i == 50 ? throw std::runtime_error("fifty") : 1; },
            nothing),
        std::runtime_error);
    CHECK_THROWS_AS(thread::in_order(
                        100, 3, [](std::size_t) { return 1; },
                        [](std::size_t i, int) {
                            if (i == 50)
                                throw std::runtime_error("fifty");
                        }),
                    std::runtime_error);
}

TEST_CASE(
    "threads are started all or none: those that run are stopped and joined when one is refused",
    "[common][thread]") {
    const int allowed = GENERATE(0, 1, 3);
    std::atomic<int> copies{0};
    std::atomic<int> ended{0};
    std::stop_source stop;
    std::vector<std::thread> threads;
    const Work work(&copies, allowed, &ended, stop.get_token());
    CHECK_THROWS_AS(thread::start_threads(threads, 4, work, [&] { stop.request_stop(); }),
                    std::system_error);
    CHECK(threads.empty());
    CHECK(ended == allowed);
}

TEST_CASE("as many threads are started as are requested", "[common][thread]") {
    const std::size_t count = GENERATE(std::size_t{0}, std::size_t{1}, std::size_t{5});
    std::atomic<std::size_t> ran{0};
    std::vector<std::thread> threads;
    thread::start_threads(threads, count, [&] { ++ran; }, [] { FAIL("they must not be stopped"); });
    REQUIRE(threads.size() == count);
    for (std::thread& t : threads)
        t.join();
    CHECK(ran == count);
}

TEST_CASE("work on a new thread is over when it returns, and its value is moved",
          "[common][thread]") {
    const auto here = std::this_thread::get_id();
    std::thread::id there = here;
    const std::unique_ptr<int> made = on_new_thread(
        [&] {
            there = std::this_thread::get_id();
            return std::make_unique<int>(7);
        },
        [] { return std::unique_ptr<int>(); });
    REQUIRE(made);
    CHECK(*made == 7);
    CHECK(there != here);
}

TEST_CASE("what work on a new thread throws reaches the caller", "[common][thread]") {
    const auto fails = []() -> int { throw std::out_of_range("too far"); };
    CHECK_THROWS_AS(on_new_thread(fails, refused), std::out_of_range);
}

TEST_CASE("work stops by either token or at its deadline", "[common][thread]") {
    std::stop_source first;
    std::stop_source second;
    const auto now = StopCondition::Clock::now();
    CHECK_FALSE(StopCondition({}).is_met());
    CHECK_FALSE(StopCondition(first.get_token(), second.get_token()).is_met());
    CHECK_FALSE(StopCondition(first.get_token(), {}, now + 1h).is_met());
    CHECK(StopCondition(first.get_token(), {}, now).is_met());

    const StopCondition either(first.get_token(), second.get_token());
    second.request_stop();
    CHECK(either.is_met());
    first.request_stop();
    CHECK(StopCondition(first.get_token()).is_met());
}

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
