#include "raytracer/shade/sky.hpp"

#include <cmath>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using terravox::test::contains;

namespace {

bool good(Colour c) { return c.r >= 0 && c.g >= 0 && c.b >= 0 && std::isfinite(c.r) && std::isfinite(c.g) && std::isfinite(c.b); }

}  // namespace

TEST_CASE("the sky is finite and never negative, whatever the sun and the direction", "[raytracer][shade][sky]") {
    const double altitude = GENERATE(-90.0, -18.0, -6.0, -0.833, 0.0, 0.5, 12.0, 45.0, 90.0);
    const double azimuth = GENERATE(0.0, 90.0, 225.0, -360.0);
    Scene scene;
    INFO("sun at " << altitude << ", " << azimuth);
    const Sky sky({altitude, azimuth}, scene.sun, scene.sky);
    std::vector<Vec3> directions = {{0, 1, 0}, {0, -1, 0}, {1, 0, 0}, {-1, -0.0, 0}, {0, 0, 1}, {0, 0, -1}, sky.to_sun(), -sky.to_sun()};
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    while (directions.size() < 2000) directions.push_back(normalized({normal(random), normal(random), normal(random)}));
    CHECK(good(sky.sun_light()));
    CHECK(std::abs(length(sky.to_sun()) - 1) < 1e-12);
    CHECK(sky.sun_up() == (sky.to_sun().y > 0));
    int bad = 0;
    for (const Vec3 d : directions) bad += good(sky.radiance(d)) && good(sky.ambient(d)) ? 0 : 1;
    CHECK(bad == 0);
}

TEST_CASE("the sky brightens with the sun's altitude and goes with the night", "[raytracer][shade][sky]") {
    Scene scene;
    const auto brightness = [&](double altitude) {
        const Colour c = Sky({altitude, 180}, scene.sun, scene.sky).radiance({0, 1, 0});
        return c.r + c.g + c.b;
    };
    CHECK(brightness(40) > brightness(5));
    CHECK(brightness(5) > brightness(-10));
    CHECK(Sky({-10, 180}, scene.sun, scene.sky).sun_light().r == 0);
    scene.sun.strength = 0, scene.sky.strength = 0;
    CHECK(brightness(40) == 0);
}

TEST_CASE("the sun stands where its azimuth says: east is +x, south is +z", "[raytracer][shade][sky]") {
    const Scene scene;
    struct Case { const char* name; double azimuth; Vec3 to; };
    const auto c = GENERATE(values<Case>({{"north", 0, {0, 0, -1}}, {"east", 90, {1, 0, 0}}, {"south", 180, {0, 0, 1}}, {"west", 270, {-1, 0, 0}}}));
    DYNAMIC_SECTION(c.name) { CHECK(length(Sky({0, c.azimuth}, scene.sun, scene.sky).to_sun() - c.to) < 1e-12); }
}

TEST_CASE("haze takes nothing near by and all but a twentieth at the stated distance", "[raytracer][shade][sky]") {
    Scene scene;
    scene.sky.visibility_km = 20;
    const Sky sky({30, 180}, scene.sun, scene.sky);
    CHECK(sky.haze(0) == 0);
    CHECK(sky.haze(20'000) == Approx(0.95).epsilon(1e-6));
    float last = 0;
    for (double m = 1; m < 1e7; m *= 1.5) {
        CHECK(sky.haze(m) >= last);
        last = sky.haze(m);
    }
    CHECK(last <= 1);
}

TEST_CASE("a sun that cannot be is refused, naming the field", "[raytracer][shade][sky]") {
    struct Case { const char* name; void (*change)(Scene::Sun&); std::string said; };
    const auto c = GENERATE(values<Case>({
        {"altitude alone", [](Scene::Sun& s) { s.altitude_deg = 10; }, "sun.azimuth_deg is missing"},
        {"azimuth alone", [](Scene::Sun& s) { s.azimuth_deg = 10; }, "sun.altitude_deg is missing"},
        {"no date", [](Scene::Sun& s) { s.date = ""; }, "sun.date = ''"},
        {"a word", [](Scene::Sun& s) { s.date = "midsummer"; }, "sun.date = 'midsummer'; allowed: YYYY-MM-DD"},
        {"31 February", [](Scene::Sun& s) { s.date = "2026-02-31"; }, "sun.date = '2026-02-31'"},
        {"month 13", [](Scene::Sun& s) { s.date = "2026-13-01"; }, "2026-13-01"},
        {"month 0", [](Scene::Sun& s) { s.date = "2026-00-01"; }, "2026-00-01"},
        {"day 32", [](Scene::Sun& s) { s.date = "2026-01-32"; }, "2026-01-32"},
        {"day 0", [](Scene::Sun& s) { s.date = "2026-01-00"; }, "2026-01-00"},
        {"text behind", [](Scene::Sun& s) { s.date = "2026-06-21T16"; }, "2026-06-21T16"},
        {"slashes", [](Scene::Sun& s) { s.date = "2026/06/21"; }, "2026/06/21"},
    }));
    DYNAMIC_SECTION(c.name) {
        Scene::Sun sun;
        c.change(sun);
        const geo::LatLon here{46, 14};
        CHECK_THROWS_AS(sun_of(sun, &here), UsageError);
        CHECK_THROWS_WITH(sun_of(sun, &here), contains(c.said) && contains("place the sun"));
    }
}

TEST_CASE("the sun comes from date, time and place, or from the angles when both are given", "[raytracer][shade][sky]") {
    Scene::Sun sun;
    const geo::LatLon delft{52.0, 4.37};
    sun.time_h = 12, sun.utc_offset_h = 0;
    const auto noon = sun_of(sun, &delft);
    CHECK(noon.altitude_deg == Approx(61.4).margin(0.5));
    CHECK(noon.azimuth_deg == Approx(187).margin(8));
    sun.utc_offset_h.reset(), sun.time_h = 24;
    CHECK(sun_of(sun, &delft).altitude_deg < 0);
    sun.altitude_deg = 5, sun.azimuth_deg = 77;
    CHECK(sun_of(sun, &delft).altitude_deg == 5);
    CHECK(sun_of(sun, nullptr).azimuth_deg == 77);
}
