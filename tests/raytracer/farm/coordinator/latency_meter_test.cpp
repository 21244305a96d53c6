#include "raytracer/farm/coordinator/worker_link.hpp"

#include <cstdint>

#include "tests/catch.hpp"

using terravox::farm::LatencyMeter;

namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;

}  // namespace

TEST_CASE("only the stamp of a ping that waits for its answer counts, and only once",
          "[raytracer][farm]") {
    LatencyMeter meter;
    CHECK_FALSE(meter.pong_received(9 * kSecond_ns, 10 * kSecond_ns));
    meter.ping_sent(10 * kSecond_ns);
    CHECK_FALSE(meter.pong_received(10 * kSecond_ns - 1, 11 * kSecond_ns));
    CHECK_FALSE(meter.pong_received(0, 11 * kSecond_ns));
    CHECK(meter.average_s() == 0);
    CHECK(meter.pong_received(10 * kSecond_ns, 11 * kSecond_ns));
    CHECK_FALSE(meter.pong_received(10 * kSecond_ns, 50 * kSecond_ns));
    CHECK(meter.average_s() == Approx(1));
}

TEST_CASE("of many pings without an answer the oldest are forgotten", "[raytracer][farm]") {
    LatencyMeter meter;
    for (std::uint64_t i = 0; i <= LatencyMeter::kMaxOutstanding; ++i)
        meter.ping_sent((1 + i) * kSecond_ns);
    CHECK_FALSE(meter.pong_received(1 * kSecond_ns, 100 * kSecond_ns));
    CHECK(meter.pong_received(2 * kSecond_ns, 100 * kSecond_ns));
    CHECK(meter.average_s() == Approx(98));
}
