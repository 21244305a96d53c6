#include <atomic>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

#include "common/util/cache.hpp"
#include "common/util/handle_pool.hpp"
#include "tests/catch.hpp"

using terravox::util::Cache;
using terravox::util::HandlePool;

namespace {

using Numbers = Cache<int, int>;
constexpr std::size_t kValueBytes = 1000;

Numbers::Ptr get(Numbers& cache, int key, std::atomic<int>* made = nullptr) {
    return cache.get(
        key, [&] { return made ? ++*made : 0, std::make_shared<const int>(key * 10); },
        [](const auto&) { return kValueBytes; });
}

}  // namespace

TEST_CASE("a cache makes each value once and counts hits and misses", "[common][util][cache]") {
    Numbers cache(100 * kValueBytes);
    std::atomic<int> made = 0;
    for (int round = 0; round < 3; ++round)
        for (int key = 0; key < 5; ++key)
            CHECK(*get(cache, key, &made) == key * 10);
    CHECK(made == 5);
    CHECK(cache.stats().hits == 10);
    CHECK(cache.stats().misses == 5);
    CHECK(cache.stats().entries == 5);
    CHECK(cache.stats().evictions == 0);
}

TEST_CASE("a cache never holds more than its limit", "[common][util][cache]") {
    Numbers cache(10 * kValueBytes);
    std::mt19937 random(1);
    for (int i = 0; i < 2000; ++i) {
        const int key = static_cast<int>(random() % 50);
        CHECK(*get(cache, key) == key * 10);
        CHECK(cache.stats().bytes <= cache.limit_bytes());
    }
    CHECK(cache.stats().evictions > 0);
}

TEST_CASE("the least recently used value goes first", "[common][util][cache]") {
    Numbers cache(kValueBytes * 7 / 2);  // three values with their bookkeeping
    std::atomic<int> made = 0;
    for (const int key : {1, 2, 3, 1, 4})
        get(cache, key, &made);
    CHECK(made == 4);
    get(cache, 1, &made);
    get(cache, 3, &made);
    get(cache, 4, &made);
    CHECK(made == 4);
    get(cache, 2, &made);
    CHECK(made == 5);
}

TEST_CASE("a value in use outlives its eviction", "[common][util][cache]") {
    Numbers cache(kValueBytes * 3 / 2);
    const auto held = get(cache, 7);
    for (int key = 100; key < 110; ++key)
        get(cache, key);
    CHECK(*held == 70);
    CHECK(cache.stats().entries == 1);
}

TEST_CASE("nullptr is a value, too, and counts towards the limit", "[common][util][cache]") {
    Numbers cache(5000);
    int made = 0;
    for (int i = 0; i < 2; ++i)
        CHECK(cache.get(
                  1, [&] { return ++made, Numbers::Ptr(); },
                  [](const auto&) { return std::size_t{0}; }) == nullptr);
    CHECK(made == 1);
    CHECK(cache.stats().bytes > 0);
}

TEST_CASE("a failure is not cached", "[common][util][cache]") {
    Numbers cache(5000);
    const auto fails = [&] {
        return cache.get(
            1, []() -> Numbers::Ptr { throw std::runtime_error("no"); },
            [](const auto&) { return std::size_t{1}; });
    };
    CHECK_THROWS_AS(fails(), std::runtime_error);
    CHECK_THROWS_AS(fails(), std::runtime_error);
    CHECK(*get(cache, 1) == 10);
}

TEST_CASE("threads that request a value being made wait for that result", "[common][util][cache]") {
    constexpr int kThreads = 6;
    Numbers cache(5000);
    std::atomic<int> made = 0;
    std::vector<std::thread> threads;
    std::vector<int> found(kThreads);
    for (int t = 0; t < kThreads; ++t)
        threads.emplace_back([&, t] {
            found[static_cast<std::size_t>(t)] = *cache.get(
                3,
                [&] {
                    // Making ends only when all others wait for it.
                    while (cache.stats().waits < kThreads - 1)
                        std::this_thread::yield();
                    return ++made, std::make_shared<const int>(30);
                },
                [](const auto&) { return std::size_t{1}; });
        });
    for (auto& thread : threads)
        thread.join();
    CHECK(made == 1);
    CHECK(found == std::vector<int>(kThreads, 30));
}

TEST_CASE("a handle is lent to one caller at a time, and stays open for the next",
          "[common][util][handle_pool]") {
    int opened = 0;
    const auto open = [&] { return std::make_unique<int>(++opened); };
    HandlePool<std::unique_ptr<int>> pool(2);
    {
        const auto first = pool.borrow(open);
        const auto second = pool.borrow(open);
        const auto third = pool.borrow(open);
        CHECK(*first == 1);
        CHECK(*second == 2);
        CHECK(*third.get() == 3);
    }
    // Given back in reverse order: 3, 2; there is no room for 1.
    int sum = 0;
    pool.for_each([&](int number) { sum += number; });
    CHECK(sum == 5);
    CHECK(*pool.borrow(open) == 2);
    {
        auto broken = pool.borrow(open);
        CHECK(*broken == 2);
        broken.drop();
    }
    CHECK(*pool.borrow(open) == 3);
    CHECK(opened == 3);
}

TEST_CASE("a handle that cannot be opened is not kept", "[common][util][handle_pool]") {
    HandlePool<std::unique_ptr<int>> pool;
    const auto fail = []() -> std::unique_ptr<int> { throw std::runtime_error("no more"); };
    CHECK_THROWS_WITH(pool.borrow(fail), "no more");
    CHECK(*pool.borrow([] { return std::make_unique<int>(7); }) == 7);
    CHECK(*pool.borrow(fail) == 7);
}
