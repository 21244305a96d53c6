#include "common/thread/parallel.hpp"

#include <sched.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include "common/thread/in_order.hpp"
#include "tests/catch.hpp"
#include "tests/common/child_process.hpp"
#include "tests/common/emulated.hpp"

using namespace terravox::thread;

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
