#include "tests/raytracer/core/sky/skies.hpp"

using namespace terravox;
using namespace terravox::test;

TEST_CASE("air takes nothing near by and all but a twentieth at the stated distance",
          "[raytracer][sky][air]") {
    const double visibility_km = GENERATE(0.05, 1.0, 20.0, 150.0, 400.0);
    scene::Scene::Sky settings;
    settings.visibility_km = visibility_km;
    const sky::Sky sky = sky_at(30, 180, settings);
    const core::Vec3 level{0.6, 0, 0.8};
    INFO("visibility " << visibility_km << " km");
    CHECK(sky.air(level, 0).transmittance.g == 1);
    CHECK(brightness(sky.air(level, 0).light) == 0);
    CHECK(sky.air(level, visibility_km * 1000).transmittance.g == Approx(0.05).epsilon(1e-3));
    float last = 1;
    for (double m = 1; m < 1e9; m *= 1.5) {
        const sky::Air air = sky.air(level, m);
        CHECK(air.transmittance.g <= last);
        CHECK(
            air.transmittance.r >=
            air.transmittance.b);  // what is far turns blue because blue is scattered into the way
        last = air.transmittance.g;
    }
}

TEST_CASE("far land and the sky meet at the horizon without a seam", "[raytracer][sky][air]") {
    const double altitude = GENERATE(60.0, 20.0, 2.0, -3.0, -12.0);
    const double clouds = GENERATE(0.0, 0.8);
    scene::Scene::Sky settings = with_clouds(clouds);
    if (GENERATE(false, true))
        settings.visibility_km = 15;
    const sky::Sky sky = sky_at(altitude, 180, settings);
    for (double azimuth = 0; azimuth < 360; azimuth += 7.7) {
        const voxel::Colour land = sky.air(direction(0, azimuth), INFINITY).light;
        const voxel::Colour above = sky.radiance(direction(0.001, azimuth));
        INFO("sun " << altitude << ", azimuth " << azimuth);
        CHECK(brightness(land) == Approx(brightness(above)).epsilon(0.02));
        CHECK(static_cast<double>(land.b) == Approx(static_cast<double>(above.b)).epsilon(0.03));
    }
}

TEST_CASE("visibility 0 takes the air before things away, not the sky", "[raytracer][sky][air]") {
    scene::Scene::Sky settings;
    settings.visibility_km = 0;
    const sky::Sky sky = sky_at(40, 180, settings);
    const sky::Sky plain = sky_at(40);
    for (const core::Vec3 d : directions(100, 9)) {
        CHECK(sky.air(d, 1e7).transmittance.b == 1);
        CHECK(brightness(sky.air(d, 1e7).light) == 0);
        CHECK(brightness(sky.radiance(d)) == brightness(plain.radiance(d)));
    }
}
