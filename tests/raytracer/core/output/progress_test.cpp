#include "raytracer/core/output/progress.hpp"

#include "tests/catch.hpp"

using namespace terravox;

TEST_CASE("no time is promised before the first tile is finished", "[raytracer][output]") {
    CHECK(output::to_time_left(0, 0) == "preparing");
    CHECK(output::to_time_left(600, 0) == "preparing");
    CHECK(output::to_time_left(3, 0.25) == "9 s left");
    CHECK(output::to_time_left(3, 1) == "0 s left");
}
