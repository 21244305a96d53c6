#include "raytracer/farm/net/refusal_log.hpp"

#include <vector>

#include "tests/catch.hpp"

using namespace std::chrono_literals;
using terravox::net::RefusalLog;

TEST_CASE("a reason is logged once a minute for each address, with the number of repetitions",
          "[common][net][log]") {
    std::vector<std::string> lines;
    RefusalLog log([&](const std::string& line) { lines.push_back(line); });
    const auto start = RefusalLog::Clock::now();
    log.refused("192.0.2.7", "192.0.2.7:1", "wrong token", start);
    for (int i = 2; i < 100; ++i)
        log.refused("192.0.2.7", "192.0.2.7:" + std::to_string(i), "wrong token", start + 59s);
    log.refused("192.0.2.7", "192.0.2.7:100", "too slow", start + 59s);
    log.refused("192.0.2.8", "192.0.2.8:1", "wrong token", start + 59s);
    log.refused("192.0.2.7", "192.0.2.7:101", "wrong token", start + 60s);
    log.refused("192.0.2.7", "192.0.2.7:102", "wrong token", start + 120s);
    CHECK(lines ==
          std::vector<std::string>{
              "farm: refused 192.0.2.7:1: wrong token", "farm: refused 192.0.2.7:100: too slow",
              "farm: refused 192.0.2.8:1: wrong token",
              "farm: refused 192.0.2.7:101: wrong token (and 98 more since, from 192.0.2.7)",
              "farm: refused 192.0.2.7:102: wrong token"});
}

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

TEST_CASE("a line begins with what was refused", "[common][net][log]") {
    std::string line;
    RefusalLog log([&](const std::string& said) { line = said; }, "farm: no work for");
    log.refused("192.0.2.7", "192.0.2.7:1", "another build");
    CHECK(line == "farm: no work for 192.0.2.7:1: another build");
}
