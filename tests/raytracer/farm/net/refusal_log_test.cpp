#include "raytracer/farm/net/endpoint.hpp"

#include <vector>

#include "tests/catch.hpp"

using namespace std::chrono_literals;
using terravox::net::RefusalLog;

TEST_CASE("a flood from very many addresses fills neither memory nor log", "[common][net][log]") {
    std::size_t lines = 0;
    RefusalLog log([&](const std::string&) { ++lines; });
    const auto start = RefusalLog::Clock::now();
    for (int i = 0; i < 100'000; ++i)
        log.refused(std::to_string(i), std::to_string(i) + ":1", "wrong token",
                    start + std::chrono::microseconds(i));
    CHECK(lines == RefusalLog::kMaxKept + 1);
    for (int i = 0; i < 100'000; ++i)
        log.refused(std::to_string(i), std::to_string(i) + ":1", "wrong token",
                    start + 61s + std::chrono::microseconds(i));
    CHECK(lines <= 2 * (RefusalLog::kMaxKept + 1));
}

TEST_CASE("a flood of reasons from one address fills neither memory nor log",
          "[common][net][log]") {
    std::size_t lines = 0;
    RefusalLog log([&](const std::string&) { ++lines; }, "farm: no work for");
    const auto start = RefusalLog::Clock::now();
    for (int i = 0; i < 100'000; ++i)
        log.refused("192.0.2.7", "192.0.2.7:1", "version " + std::to_string(i),
                    start + std::chrono::microseconds(i));
    CHECK(lines == RefusalLog::kMaxKept + 1);
}
