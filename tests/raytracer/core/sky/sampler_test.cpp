#include "tests/raytracer/core/sky/skies.hpp"

using namespace terravox;
using namespace terravox::test;

TEST_CASE("densities of the sky's samples sum to one, and are nowhere nothing above the horizon",
          "[raytracer][sky][sampler]") {
    const double altitude = GENERATE(70.0, 8.0, -5.0, -30.0);
    scene::Scene scene;
    scene.sky.clouds = altitude > 50 ? 0.5 : 0;
    scene.sky.strength = altitude < -20 ? 0 : 1;
    const sky::Sky sky({altitude, 77}, scene.sun, scene.sky, 0);
    double sum = 0;
    double least = 1;
    over_sphere(400'000, 0, [&](core::Vec3 d, double sr) {
        sum += sky.pdf(d) * sr;
        least = std::min(least, sky.pdf(d));
    });
    CHECK(sum == Approx(1).epsilon(1e-3));
    CHECK(least > 1e-3);
    CHECK(sky.pdf({0, -1, 0}) == 0);
    CHECK(sky.pdf({1, -1e-9, 0}) == 0);
    CHECK(sky.pdf({0, 1, 0}) > 0);
    CHECK(sky.pdf({1, 0, 0}) > 0);
}

TEST_CASE("a sample's density is that of its direction, and samples find the sky's light",
          "[raytracer][sky][sampler]") {
    const double altitude = GENERATE(70.0, 8.0, -5.0);
    const sky::Sky sky = sky_at(altitude, 300);
    double found = 0;
    double wanted = 0;
    double worst = 0;
    constexpr int kSide = 300;
    int apart = 0;
    for (int i = 0; i < kSide; ++i)
        for (int j = 0; j < kSide; ++j) {
            const sky::SkySample s = sky.sample((i + 0.5) / kSide, (j + 0.5) / kSide);
            REQUIRE(s.direction.y >= 0);
            REQUIRE(std::abs(core::length(s.direction) - 1) < 1e-12);
            REQUIRE(s.pdf > 0);
            apart += s.pdf == sky.pdf(s.direction) ? 0 : 1;
            const double part = brightness(sky.radiance(s.direction)) * s.direction.y / s.pdf;
            found += part / (kSide * kSide);
            worst = std::max(worst, part);
        }
    over_sphere(200'000, 0,
                [&](core::Vec3 d, double sr) { wanted += brightness(sky.radiance(d)) * d.y * sr; });
    CHECK(apart <= kSide * kSide / 1000);  // on the edge between two cells rounding decides
    CHECK(found == Approx(wanted).epsilon(0.01));
    CHECK(worst < 12 * wanted);  // no direction brings a firefly
    for (const double u : {0.0, 1 - 0x1p-53})
        for (const double v : {0.0, 1 - 0x1p-53})
            CHECK(std::abs(core::length(sky.sample(u, v).direction) - 1) < 1e-12);
}
