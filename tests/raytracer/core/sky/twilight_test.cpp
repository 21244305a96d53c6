#include "tests/raytracer/core/sky/skies.hpp"

using namespace terravox;
using namespace terravox::test;

TEST_CASE("the light goes with the sun, evenly and without a jump, down to the glow of the night",
          "[raytracer][sky][twilight][all]") {
    const double clouds = GENERATE(0.0, 0.4);
    const core::Vec3 up{0, 1, 0};
    constexpr double kStep_deg = 0.25;
    double last = 0;
    double last_fall = 0;
    double last_sun = 100;
    for (double altitude = 10; altitude >= -20; altitude -= kStep_deg) {
        const sky::Sky sky = sky_at(altitude, 250, with_clouds(clouds));
        const double now = brightness(sky.ambient(up));
        const double sun = brightness(sky.sun_light());
        INFO("sun at " << altitude << ": " << now << " after " << last);
        CHECK(now > 0);
        CHECK(sun <= last_sun);
        if (last > 0) {
            CHECK(now <= last * 1.000001);
            const double fall = std::log(last / now) / kStep_deg;
            CHECK(fall < 1.6);  // the steepest dusk: a factor of five for each degree
            if (altitude < 9.5)
                CHECK(std::abs(fall - last_fall) < 0.3);
            last_fall = fall;
        }
        last = now;
        last_sun = sun;
    }
    CHECK(last < 1e-4);
    CHECK(brightness(sky_at(-25).ambient(up)) ==
          Approx(brightness(sky_at(-60).ambient(up))).epsilon(0.01));
}
