#include "raytracer/apps/preview/frame_pacer.hpp"

#include "tests/catch.hpp"

using namespace terravox;
using namespace std::chrono_literals;
using preview::Activity;
using preview::FramePacer;

namespace {

const FramePacer::Clock::time_point kStart;

}  // namespace

TEST_CASE("a frame waits for input as long as nothing has to be computed", "[preview]") {
    CHECK(FramePacer::wait_s(Activity::kComputing) == 0);
    CHECK(FramePacer::wait_s(Activity::kAnimated) == Approx(1.0 / 60));
    CHECK(FramePacer::wait_s(Activity::kIdle) == Approx(0.25));
}

TEST_CASE("the window comes to rest once, until there is activity again", "[preview]") {
    FramePacer pacer(kStart);
    CHECK_FALSE(pacer.comes_to_rest(false));
    CHECK(pacer.comes_to_rest(true));
    CHECK_FALSE(pacer.comes_to_rest(true));
    CHECK_FALSE(pacer.comes_to_rest(false));
    CHECK(pacer.comes_to_rest(true));
}
