// What the box cache promises beyond tests/common/util/cache_test.cpp: failures with waiters,
// values too large to keep.
#include <atomic>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "common/util/cache.hpp"
#include "tests/catch.hpp"

using Texts = terravox::util::Cache<int, std::string>;

namespace {

std::size_t weight(const Texts::Ptr& p) {
    return p ? p->size() : 0;
}

}  // namespace

TEST_CASE("what making throws reaches every thread that waits for it, and the next one makes anew",
          "[common][util][cache]") {
    constexpr int kThreads = 6;
    Texts cache(10'000);
    std::atomic<int> made{0}, caught{0};
    std::vector<std::thread> threads;
    for (int t = 0; t < kThreads; ++t)
        threads.emplace_back([&] {
            try {
                (void)cache.get(
                    1,
                    [&]() -> Texts::Ptr {
                        ++made;
                        while (cache.stats().waits < kThreads - 1)
                            std::this_thread::yield();  // until all others wait
                        throw std::out_of_range("no such box");
                    },
                    weight);
            } catch (const std::out_of_range& e) {
                caught += std::string(e.what()) == "no such box" ? 1 : 0;
            }
        });
    for (auto& t : threads)
        t.join();
    CHECK(made == 1);
    CHECK(caught == kThreads);
    CHECK(cache.stats().entries == 0);
    CHECK(
        *cache.get(1, [] { return std::make_shared<const std::string>("now"); }, weight) == "now");
}

TEST_CASE("a value larger than the limit is handed out, not kept, and pushes nothing else over it",
          "[common][util][cache]") {
    Texts cache(1000);
    int made = 0;
    const auto large = [&] {
        return cache.get(
            1, [&] { return ++made, std::make_shared<const std::string>(5000, 'x'); }, weight);
    };
    CHECK(large()->size() == 5000);
    CHECK(cache.stats().bytes <= 1000);
    CHECK(large()->size() == 5000);
    CHECK(made == 2);
    CHECK(cache.stats().entries == 0);
}

TEST_CASE("weighing that throws leaves the cache as it was", "[common][util][cache]") {
    Texts cache(1000);
    const auto value = [] { return std::make_shared<const std::string>("x"); };
    CHECK_THROWS_AS(
        cache.get(1, value, [](const auto&) -> std::size_t { throw std::runtime_error("scales"); }),
        std::runtime_error);
    CHECK(cache.stats().entries == 0);
    CHECK(*cache.get(1, value, weight) == "x");
}
