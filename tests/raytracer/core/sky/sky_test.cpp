#include "raytracer/core/sky/sky.hpp"

#include <cstring>
#include <random>

#include "tests/raytracer/core/sky/skies.hpp"

using namespace terravox;
using namespace terravox::test;

TEST_CASE("the sky is finite and never negative, whatever the sun, the air and the direction",
          "[raytracer][sky]") {
    using Sun = std::pair<double, double>;
    const auto sun = GENERATE(values<Sun>({{-90, 0},
                                           {-18, 225},
                                           {-6, -360},
                                           {-0.833, 0},
                                           {0, 225},
                                           {0.5, -360},
                                           {12, 0},
                                           {45, 225},
                                           {89.9999, -360},
                                           {90, 0}}));
    const double altitude = sun.first;
    const double azimuth = sun.second;
    std::mt19937 random(static_cast<unsigned>(altitude * 7 + azimuth + 1000));
    scene::Scene scene;
    scene.sky.turbidity = std::uniform_real_distribution<double>(1.5, 10)(random);
    scene.sky.clouds = azimuth == 0 ? 0 : 0.6;
    scene.sky.cloud_height_m = azimuth < 0 ? 12000 : 100;
    const double place_m = std::uniform_real_distribution<double>(-500, 9000)(random);
    INFO("sun at " << altitude << ", " << azimuth << "; turbidity " << scene.sky.turbidity
                   << ", place at " << place_m << " m");
    const sky::Sky sky({altitude, azimuth}, scene.sun, scene.sky, place_m);
    std::vector<core::Vec3> all = directions(1500, 5);
    all.push_back(sky.to_sun());
    all.push_back(-sky.to_sun());
    CHECK(good(sky.sun_light()));
    CHECK(std::abs(core::length(sky.to_sun()) - 1) < 1e-12);
    int bad = 0;
    for (const core::Vec3 d : all) {
        bad += good(sky.radiance(d)) && good(sky.ambient(d)) && good(sky.sun_disc(d)) &&
                       std::isfinite(sky.pdf(d))
                   ? 0
                   : 1;
        for (const double metres : {0.0, 1.0, 1e4, 1e30, static_cast<double>(INFINITY)}) {
            const sky::Air air = sky.air(d, metres);
            bad += good(air.light) && good(air.transmittance) && air.transmittance.r <= 1 &&
                           air.transmittance.b <= 1
                       ? 0
                       : 1;
        }
        const float passing = sky.cloud_shadow(d * 1e4);
        bad += passing >= 0 && passing <= 1 ? 0 : 1;
    }
    CHECK(bad == 0);
}

TEST_CASE("a direction that is none does no harm", "[raytracer][sky]") {
    const double none = std::nan("");
    const double endless = INFINITY;
    for (const double altitude : {40.0, -20.0}) {
        const sky::Sky sky = sky_at(altitude, 180, with_clouds(0.5));
        int asked = 0;
        for (const core::Vec3 d : {core::Vec3{none, none, none},
                                   {0, 0, 0},
                                   {none, 0.5, 0},
                                   {0, none, 1},
                                   {endless, 0.1, 0},
                                   {0, endless, -endless},
                                   {1e300, 1e300, 0}}) {
            (void)sky.radiance(d);
            (void)sky.ambient(d);
            (void)sky.sun_disc(d);
            (void)sky.pdf(d);
            (void)sky.air(d, none);
            (void)sky.cloud_shadow(d);
            ++asked;
        }
        CHECK(asked == 7);
    }
}

TEST_CASE("the sun is at its azimuth: east is +x, south is +z", "[raytracer][sky]") {
    struct Case {
        const char* name;
        double azimuth;
        core::Vec3 to;
    };
    const auto c = GENERATE(values<Case>({{"north", 0, {0, 0, -1}},
                                          {"east", 90, {1, 0, 0}},
                                          {"south", 180, {0, 0, 1}},
                                          {"west", 270, {-1, 0, 0}}}));
    DYNAMIC_SECTION(c.name) {
        CHECK(core::length(sky_at(0, c.azimuth).to_sun() - c.to) < 1e-12);
    }
}

TEST_CASE("ambient light is what radiance sums to", "[raytracer][sky]") {
    const double altitude = GENERATE(60.0, 20.0, 4.0, -3.0, -15.0);
    const double clouds = GENERATE(0.0, 0.5);
    const sky::Sky sky = sky_at(altitude, 200, with_clouds(clouds));
    struct Sum {
        core::Vec3 normal;
        voxel::Colour sum;
    };
    std::vector<Sum> sums;
    for (const core::Vec3 n : directions(24, 8))
        sums.push_back({core::normalized(n), {}});
    over_sphere(60'000, -1, [&](core::Vec3 d, double sr) {
        const voxel::Colour light = sky.radiance(d);
        for (Sum& s : sums)
            if (const double c = core::dot(s.normal, d); c > 0)
                s.sum = s.sum + light * static_cast<float>(c * sr / det::kPi);
    });
    for (const Sum& s : sums) {
        INFO("sun " << altitude << ", clouds " << clouds << ", normal " << s.normal.x << " "
                    << s.normal.y << " " << s.normal.z);
        const voxel::Colour found = sky.ambient(s.normal);
        CHECK(brightness(found) == Approx(brightness(s.sum)).epsilon(0.02));
        CHECK(static_cast<double>(found.b) == Approx(static_cast<double>(s.sum.b)).epsilon(0.02));
    }
}

TEST_CASE("the sky is the same on both sides of the sun, and turns with it", "[raytracer][sky]") {
    const sky::Sky south = sky_at(25, 180);
    const sky::Sky west = sky_at(25, 270);
    for (double altitude = -60; altitude < 90; altitude += 7.3)
        for (double aside = 0; aside < 180; aside += 11.1) {
            INFO(altitude << " high, " << aside << " from the sun");
            const double left = brightness(south.radiance(direction(altitude, 180 - aside)));
            const double right = brightness(south.radiance(direction(altitude, 180 + aside)));
            CHECK(left == Approx(right).epsilon(1e-5));
            CHECK(brightness(west.radiance(direction(altitude, 270 + aside))) ==
                  Approx(right).epsilon(1e-5));
        }
}

TEST_CASE("a clear sky has no seam anywhere", "[raytracer][sky]") {
    using Case = std::pair<double, double>;
    const auto c =
        GENERATE(values<Case>({{90, 0}, {50, 0.7}, {10, 0}, {1, 0.7}, {1, 0}, {-5, 0}, {-9, 0}}));
    const double altitude = c.first;
    const double clouds = c.second;
    const sky::Sky sky = sky_at(altitude, 180, with_clouds(clouds));
    // Along circles through all azimuths, zenith and horizon, a hundredth of a degree changes
    // little; stars apart, which are points.
    constexpr double kStep_deg = 0.01;
    for (const double azimuth : {37.0, 171.0}) {
        double last = -1;
        for (double a = -180; a < 180; a += kStep_deg) {
            if (altitude < -4 && a > 0.5 && a < 179.5) {
                last = -1;
                continue;
            }
            if (clouds > 0 && std::abs(a) > 0.2) {
                last = -1;
                continue;
            }  // clouds have edges; at the horizon they fade
            const double now = brightness(sky.radiance(direction(a, azimuth)));
            if (last >= 0 && !(std::abs(now - last) < 0.02 * std::max(now, last))) {
                INFO("sun " << altitude << ", along azimuth " << azimuth << " at " << a << ": "
                            << last << " to " << now);
                CHECK(std::abs(now - last) < 0.02 * std::max(now, last));
            }
            last = now;
        }
    }
    CHECK(brightness(sky.radiance({1, 1e-9, 0})) ==
          Approx(brightness(sky.radiance({1, -1e-9, 0}))).epsilon(1e-3));
}

TEST_CASE("strengths multiply; without them there is no light", "[raytracer][sky]") {
    scene::Scene scene;
    const sky::Sky plain({30, 180}, scene.sun, scene.sky, 0);
    scene.sky.strength = 2;
    scene.sun.strength = 0.5;
    const sky::Sky changed({30, 180}, scene.sun, scene.sky, 0);
    const core::Vec3 d = direction(40, 80);
    CHECK(brightness(changed.radiance(d)) == Approx(2 * brightness(plain.radiance(d))));
    CHECK(brightness(changed.sun_light()) == Approx(0.5 * brightness(plain.sun_light())));
    scene.sky.strength = 0;
    scene.sun.strength = 0;
    scene.sky.clouds = 0.5;
    const sky::Sky dark({30, 180}, scene.sun, scene.sky, 0);
    for (const core::Vec3 any : directions(200, 3))
        CHECK(brightness(dark.radiance(any) + dark.ambient(any) + dark.sun_disc(any) +
                         dark.air(any, 1e4).light) == 0);
}

TEST_CASE("a uniform sky is one colour all around, without air unless visibility is set",
          "[raytracer][sky]") {
    scene::Scene scene;
    scene.sky.model = core::SkyModel::kUniform;
    scene.sky.clouds = 1;
    scene.sky.strength = 2;
    const auto is = [](voxel::Colour c, voxel::Colour wanted) {
        return c.r == wanted.r && c.g == wanted.g && c.b == wanted.b;
    };
    const sky::Sky white({30, 180}, scene.sun, scene.sky, 0);
    scene.sky.colour = std::array<double, 3>{0.25, 0.5, 1};
    scene.sky.visibility_km = 10;
    const sky::Sky blue({30, 180}, scene.sun, scene.sky, 0);
    for (const core::Vec3 d : directions(500, 4)) {
        CHECK((is(white.radiance(d), {2, 2, 2}) && is(white.ambient(d), {2, 2, 2})));
        CHECK((is(white.air(d, 1e6).transmittance, {1, 1, 1}) && is(white.air(d, 1e6).light, {})));
        CHECK((is(blue.radiance(d), {0.5f, 1, 2}) && is(blue.ambient(d), {0.5f, 1, 2})));
    }
    CHECK(blue.air({1, 0, 0}, 10'000).light.g == Approx(0.95f).epsilon(1e-4));
    CHECK(white.cloud_shadow({0, 0, 0}) == 1);
    CHECK(brightness(white.sun_light()) > 1);
}

TEST_CASE("the same sky is the same to the last bit, whichever was made before",
          "[raytracer][sky]") {
    const sky::Sky first = sky_at(17, 100, with_clouds(0.4));
    const sky::Sky between = sky_at(50);
    const sky::Sky second = sky_at(17, 100, with_clouds(0.4));
    const sky::Sky again = sky_at(17, 100, with_clouds(0.4));
    CHECK(brightness(between.radiance({0, 1, 0})) != brightness(first.radiance({0, 1, 0})));
    for (const core::Vec3 d : directions(3000, 6)) {
        const voxel::Colour a = first.radiance(d) + first.ambient(d);
        const voxel::Colour b = second.radiance(d) + second.ambient(d);
        const voxel::Colour c = again.radiance(d) + again.ambient(d);
        REQUIRE(std::memcmp(&a, &b, sizeof a) == 0);
        REQUIRE(std::memcmp(&a, &c, sizeof a) == 0);
    }
}
