#include "common/thread/start_threads.hpp"

#include <atomic>
#include <new>
#include <stop_token>
#include <system_error>

#include "tests/catch.hpp"

using namespace terravox;

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

}  // namespace

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
