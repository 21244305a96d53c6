#include "raytracer/core/sky/weather.hpp"

#include <random>

#include "tests/raytracer/core/sky/skies.hpp"

using namespace terravox;
using namespace terravox::test;

TEST_CASE("clouds cover the requested share of the sky", "[raytracer][sky][clouds]") {
    const double cover = GENERATE(0.0, 0.1, 0.4, 0.75, 1.0);
    const sky::Clouds clouds(cover);
    std::mt19937 random(31);
    std::uniform_real_distribution<double> place(-6e6, 6e6);
    constexpr int kPlaces = 20'000;
    int covered = 0;
    double passing = 0;
    for (int i = 0; i < kPlaces; ++i) {
        const double depth = clouds.depth(place(random), place(random));
        REQUIRE(depth >= 0);
        REQUIRE(depth <= sky::Clouds::kThickest);
        covered += depth > 0 ? 1 : 0;
        passing += std::exp(-depth) / kPlaces;
    }
    INFO("cover " << cover);
    CHECK(covered / static_cast<double>(kPlaces) == Approx(cover).margin(0.025));
    CHECK(passing == Approx(clouds.mean_passing()).margin(0.025));
}

TEST_CASE("clouds are smooth, also far from the origin, and end where numbers do",
          "[raytracer][sky][clouds]") {
    const sky::Clouds clouds(0.5);
    std::mt19937 random(32);
    std::uniform_real_distribution<double> place(-6e6, 6e6);
    for (int i = 0; i < 20'000; ++i) {
        const double x = place(random);
        const double z = place(random);
        INFO(x << ", " << z);
        REQUIRE(std::abs(clouds.depth(x, z) - clouds.depth(x + 0.05, z - 0.05)) < 0.3);
    }
    for (const double extreme : {1e9, -1e300, static_cast<double>(INFINITY), std::nan("")}) {
        CHECK(clouds.depth(extreme, 0) == 0);
        CHECK(clouds.depth(0, extreme) == 0);
    }
}

TEST_CASE("a place is in the shadow of the clouds that stand before its sun",
          "[raytracer][sky][clouds]") {
    scene::Scene scene;
    scene.sky.clouds = 0.5;
    std::mt19937 random(33);
    std::uniform_real_distribution<double> place(-6e6, 6e6);
    const sky::Sky clear({60, 130}, scene.sun, scene::Scene::Sky{}, 200);
    double apart = 0;
    int dark = 0;
    constexpr int kPlaces = 60;
    for (int i = 0; i < kPlaces; ++i) {
        const core::Vec3 eye{place(random), 200, place(random)};
        const sky::Sky sky({60, 130}, scene.sun, scene.sky, 200, eye);
        const double seen =
            brightness(sky.sun_disc(sky.to_sun())) / brightness(clear.sun_disc(clear.to_sun()));
        const double shadow = static_cast<double>(sky.cloud_shadow(eye));
        apart += std::abs(seen - shadow) / kPlaces;
        dark += shadow < 0.5 ? 1 : 0;
    }
    CHECK(apart < 0.01);
    CHECK(dark > kPlaces / 5);
    CHECK(dark < kPlaces * 4 / 5);
    const sky::Sky sky({60, 130}, scene.sun, scene.sky, 200);
    for (int i = 0; i < 100; ++i)
        CHECK(sky.cloud_shadow({place(random), 200 + 1500, place(random)}) == 1);
}
