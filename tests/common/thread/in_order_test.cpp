#include "common/thread/in_order.hpp"

#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;

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
