#include "raytracer/processors/speed_meter.hpp"

#include "tests/catch.hpp"
#include "tests/raytracer/processors/pool_parts.hpp"

using namespace terravox;
using namespace terravox::test;
using processors::SpeedMeter;

TEST_CASE("a speed is pixels by the time with work", "[raytracer][sched]") {
    SpeedMeter meter(false);
    CHECK(meter.pixels_per_s() == 0);
    meter.start(at_s(10));
    meter.advance(at_s(10.5));
    meter.add_answer(1000);
    CHECK(meter.pixels_per_s() == Approx(2000));
    meter.stop(at_s(10.5));
    meter.start(at_s(1000));
    CHECK(meter.pixels_per_s() == Approx(2000));
}

TEST_CASE("a start while there is work changes nothing", "[raytracer][sched]") {
    SpeedMeter meter(false);
    meter.start(at_s(1));
    meter.start(at_s(2));
    meter.advance(at_s(3));
    meter.add_answer(1000);
    CHECK(meter.pixels_per_s() == Approx(500));
}

TEST_CASE("the time before the first answer of a worker does not count for its speed",
          "[raytracer][sched]") {
    SpeedMeter meter(true);
    meter.start(at_s(0));
    meter.advance(at_s(60));
    meter.add_answer(1000);
    CHECK(meter.pixels_per_s() == 0);
    meter.advance(at_s(61));
    meter.add_answer(3000);
    CHECK(meter.pixels_per_s() == Approx(3000));
    CHECK(meter.busy_s(at_s(61)) == Approx(61));
}

TEST_CASE("after four seconds of work, earlier ones count half", "[raytracer][sched]") {
    SpeedMeter meter(false);
    meter.start(at_s(0));
    meter.advance(at_s(4));
    meter.add_answer(4000);
    CHECK(meter.pixels_per_s() == Approx(1000));
    meter.advance(at_s(8));
    meter.add_answer(40'000);
    CHECK(meter.pixels_per_s() == Approx((2000 + 40'000) / (2.0 + 4.0)));
}

TEST_CASE("the time with work is counted up to now", "[raytracer][sched]") {
    SpeedMeter meter(false);
    CHECK_FALSE(meter.is_busy());
    meter.start(at_s(1));
    CHECK(meter.is_busy());
    CHECK(meter.busy_s(at_s(3)) == Approx(2));
    meter.stop(at_s(4));
    CHECK_FALSE(meter.is_busy());
    CHECK(meter.busy_s(at_s(100)) == Approx(3));
}
