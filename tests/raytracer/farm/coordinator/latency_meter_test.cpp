#include "raytracer/farm/coordinator/latency_meter.hpp"

#include <cstdint>

#include "tests/catch.hpp"

using terravox::farm::LatencyMeter;

namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;

}  // namespace

TEST_CASE("the latency is a moving average of the times until pings are answered",
          "[raytracer][farm]") {
    LatencyMeter meter;
    CHECK(meter.average_s() == 0);
    meter.ping_sent(10 * kSecond_ns);
    CHECK(meter.average_s() == 0);
    CHECK(meter.pong_received(10 * kSecond_ns, 12 * kSecond_ns));
    CHECK(meter.average_s() == Approx(2));
    meter.ping_sent(20 * kSecond_ns);
    CHECK(meter.pong_received(20 * kSecond_ns, 21 * kSecond_ns));
    CHECK(meter.average_s() == Approx(0.8 * 2 + 0.2 * 1));
}

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

TEST_CASE("answers that take longer than the interval of the pings are measured",
          "[raytracer][farm]") {
    LatencyMeter meter;
    for (const std::uint64_t second : {1, 2, 3, 4})
        meter.ping_sent(second * kSecond_ns);
    CHECK(meter.pong_received(2 * kSecond_ns, 5 * kSecond_ns));
    CHECK(meter.average_s() == Approx(3));
    // A link keeps the order: an earlier ping gets no answer after that of a later one.
    CHECK_FALSE(meter.pong_received(1 * kSecond_ns, 6 * kSecond_ns));
    CHECK(meter.pong_received(3 * kSecond_ns, 6 * kSecond_ns));
    CHECK(meter.pong_received(4 * kSecond_ns, 7 * kSecond_ns));
    CHECK(meter.average_s() == Approx(3));
}

TEST_CASE("of many pings without an answer the oldest are forgotten", "[raytracer][farm]") {
    LatencyMeter meter;
    for (std::uint64_t i = 0; i <= LatencyMeter::kMaxOutstanding; ++i)
        meter.ping_sent((1 + i) * kSecond_ns);
    CHECK_FALSE(meter.pong_received(1 * kSecond_ns, 100 * kSecond_ns));
    CHECK(meter.pong_received(2 * kSecond_ns, 100 * kSecond_ns));
    CHECK(meter.average_s() == Approx(98));
}
