#include "raytracer/core/sky/sun.hpp"

#include <GeographicLib/Geodesic.hpp>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "tests/raytracer/core/sky/skies.hpp"

using namespace terravox;
using namespace terravox::test;

TEST_CASE("samples of the sun fill its disc evenly", "[raytracer][sky][sun]") {
    const double size = GENERATE(0.0, 1.0, 30.0);
    const sky::Sun sun({33, 120}, size);
    const double radius = 0.2666 * size * det::kPi / 180;
    CHECK(sun.radius_rad() == Approx(radius).margin(1e-12));
    int inner = 0;
    core::Vec3 mean;
    constexpr int kSide = 200;
    for (int i = 0; i < kSide; ++i)
        for (int j = 0; j < kSide; ++j) {
            const core::Vec3 d = sun.sample((i + 0.5) / kSide, (j + 0.5) / kSide);
            const double apart = 2 * std::asin(core::length(d - sun.direction()) / 2);
            REQUIRE(std::abs(core::length(d) - 1) < 1e-12);
            REQUIRE(apart <= radius * (1 + 1e-9) + 1e-15);
            inner += apart < radius / 2 ? 1 : 0;
            mean = mean + d * (1.0 / (kSide * kSide));
        }
    // Half the radius holds a quarter of the disc, nearly.
    if (size > 0)
        CHECK(inner == Approx(kSide * kSide / 4).epsilon(0.02));
    CHECK(core::length(core::normalized(mean) - sun.direction()) < 1e-6);
}

TEST_CASE("the disc's radiance sums to the sun's light, also while it sets",
          "[raytracer][sky][sun]") {
    const double altitude = GENERATE(40.0, 0.5, 0.1, 0.0, -0.15);
    const double size = GENERATE(0.5, 1.0, 20.0);
    scene::Scene scene;
    scene.sun.size = size;
    const sky::Sky sky({altitude, 10}, scene.sun, scene.sky, 0);
    const double radius = sky.sun_radius_rad();
    const double solid_angle = 2 * det::kPi * (1 - std::cos(radius));
    constexpr int kSide = 200;
    double sum = 0;
    for (int i = 0; i < kSide; ++i)
        for (int j = 0; j < kSide; ++j)
            sum += brightness(sky.sun_disc(sky.sample_sun((i + 0.5) / kSide, (j + 0.5) / kSide))) /
                   (kSide * kSide);
    INFO("sun at " << altitude << ", size " << size);
    CHECK(sky.sun_up() == (altitude * det::kPi / 180 + radius > 0));
    // Limb darkening over a cut disc leaves a little more or less than its share.
    if (sky.sun_up())
        CHECK(sum * solid_angle / det::kPi ==
              Approx(brightness(sky.sun_light()))
                  .epsilon(altitude > radius * 180 / det::kPi ? 0.005 : 0.15));
    CHECK(brightness(sky.sun_disc(-sky.to_sun())) == 0);
    CHECK(brightness(sky.sun_disc({0, 1, 0})) == 0);
    if (altitude > 30)
        CHECK(brightness(sky.sun_disc(sky.to_sun())) > 1.2 * sum);
}

TEST_CASE("a point has light but no disc", "[raytracer][sky][sun]") {
    scene::Scene scene;
    scene.sun.size = 0;
    const sky::Sky sky({40, 10}, scene.sun, scene.sky, 0);
    CHECK(sky.sun_radius_rad() == 0);
    CHECK(brightness(sky.sun_light()) == brightness(sky_at(40).sun_light()));
    CHECK(brightness(sky.sun_disc(sky.to_sun())) == 0);
    CHECK(core::length(sky.sample_sun(0.3, 0.9) - sky.to_sun()) < 1e-15);
}

TEST_CASE("light set by a scene replaces the air's, and still sets", "[raytracer][sky][sun]") {
    scene::Scene scene;
    scene.sun.light = std::array<double, 3>{1, 0.5, 0.25};
    scene.sun.strength = 2;
    const auto light = [&](double altitude) {
        return sky::Sky({altitude, 90}, scene.sun, scene.sky, 0).sun_light();
    };
    CHECK(light(40).r == Approx(2));
    CHECK(light(3).b == Approx(0.5));
    CHECK(light(0).g == Approx(0.5).epsilon(0.01));
    CHECK(brightness(light(-0.3)) == 0);
    CHECK(brightness(light(-40)) == 0);
}

TEST_CASE("a zone's clock is that of its summer and winter", "[raytracer][sky][sun]") {
    const geo::MapPlace bled{46.3683, 14.1146};
    scene::Scene::Sun by_zone;
    scene::Scene::Sun by_offset;
    by_zone.zone = "Europe/Ljubljana";
    for (const auto& [date, offset_h] : {std::pair{"2026-06-21", 2.0}, {"2026-12-21", 1.0}}) {
        by_zone.date = by_offset.date = date;
        by_offset.utc_offset_h = offset_h;
        INFO(date);
        CHECK(sky::compute_sun(by_zone, &bled).azimuth_deg ==
              sky::compute_sun(by_offset, &bled).azimuth_deg);
    }
    by_zone.utc_offset_h = 5;
    by_offset.utc_offset_h = 5;
    CHECK(sky::compute_sun(by_zone, &bled).azimuth_deg ==
          sky::compute_sun(by_offset, &bled).azimuth_deg);
    by_zone.utc_offset_h.reset();
    by_zone.zone = "Europe/Bled";
    CHECK_THROWS_AS(sky::compute_sun(by_zone, &bled), util::UsageError);
    CHECK_THROWS_WITH(sky::compute_sun(by_zone, &bled), contains("'Europe/Bled' is not known"));
}

TEST_CASE("a sun that cannot be is refused, naming the field", "[raytracer][sky][sun]") {
    struct Case {
        const char* name;
        void (*change)(scene::Scene::Sun&);
        std::string said;
    };
    const auto c = GENERATE(values<Case>({
        {"altitude alone", [](scene::Scene::Sun& s) { s.altitude_deg = 10; },
         "sun.azimuth_deg is missing"},
        {"azimuth alone", [](scene::Scene::Sun& s) { s.azimuth_deg = 10; },
         "sun.altitude_deg is missing"},
        {"no date", [](scene::Scene::Sun& s) { s.date = ""; }, "sun.date = ''"},
        {"a word", [](scene::Scene::Sun& s) { s.date = "midsummer"; },
         "sun.date = 'midsummer'; allowed: YYYY-MM-DD"},
        {"31 February", [](scene::Scene::Sun& s) { s.date = "2026-02-31"; },
         "sun.date = '2026-02-31'"},
        {"month 13", [](scene::Scene::Sun& s) { s.date = "2026-13-01"; }, "2026-13-01"},
        {"day 32", [](scene::Scene::Sun& s) { s.date = "2026-01-32"; }, "2026-01-32"},
        {"day 0", [](scene::Scene::Sun& s) { s.date = "2026-01-00"; }, "2026-01-00"},
        {"30 February of another year", [](scene::Scene::Sun& s) { s.date = "2025-02-30"; },
         "sun.date = '2025-02-30' is no day of the calendar"},
        {"25 o'clock", [](scene::Scene::Sun& s) { s.time_h = 25; },
         "sun.time_h = 25.000000; allowed: 0 to 24"},
        {"no time at all", [](scene::Scene::Sun& s) { s.time_h = std::nan(""); },
         "sun.time_h = nan"},
    }));
    DYNAMIC_SECTION(c.name) {
        scene::Scene::Sun sun;
        c.change(sun);
        const geo::MapPlace here{46, 14};
        CHECK_THROWS_AS(sky::compute_sun(sun, &here), util::UsageError);
        CHECK_THROWS_WITH(sky::compute_sun(sun, &here),
                          contains(c.said) && contains("place the sun"));
    }
}

TEST_CASE("the sun comes from date, time and place, or from the angles when both are given",
          "[raytracer][sky][sun]") {
    scene::Scene::Sun sun;
    const geo::MapPlace delft{52.0, 4.37};
    sun.time_h = 12;
    sun.utc_offset_h = 0;
    const auto noon = sky::compute_sun(sun, &delft);
    CHECK(noon.altitude_deg == Approx(61.4).margin(0.5));
    CHECK(noon.azimuth_deg == Approx(187).margin(8));
    sun.utc_offset_h.reset();
    sun.time_h = 24;
    CHECK(sky::compute_sun(sun, &delft).altitude_deg < 0);
    sun.altitude_deg = 5;
    sun.azimuth_deg = 77;
    CHECK(sky::compute_sun(sun, &delft).altitude_deg == 5);
    CHECK(sky::compute_sun(sun, nullptr).azimuth_deg == 77);
}

TEST_CASE("on a map the sun stands over the places that lie under it on Earth",
          "[raytracer][sky][sun]") {
    // A straight way on Earth towards the sun, drawn on the map, is the direction of the map's sun.
    struct Case {
        const char* crs;
        double easting, northing;
    };
    const auto c = GENERATE(values<Case>({{"EPSG:32633", 820'000, 5'100'000},
                                          {"EPSG:3794", 374'000, 35'000},
                                          {"EPSG:32733", 180'000, 6'200'000},
                                          {"EPSG:28992", 155'000, 463'000}}));
    INFO(c.crs);
    const geo::Crs crs = geo::Crs::from_text(c.crs);
    const geo::MapPlace place = geo::map_place(crs, c.easting, c.northing);
    const geo::Transform to_map(geo::Crs::from_text("EPSG:4326"), crs);
    scene::Scene::Sun sun;
    sun.utc_offset_h = 0;
    for (const double time_h : {7.0, 10.5, 12.0, 16.0}) {
        sun.time_h = time_h;
        const double true_azimuth_deg =
            geo::sun_position(sky::to_time(sun, &place), place).azimuth_deg;
        double lat_deg = 0;
        double lon_deg = 0;
        GeographicLib::Geodesic::WGS84().Direct(place.lat_deg, place.lon_deg, true_azimuth_deg, 50,
                                                lat_deg, lon_deg);
        double x = lon_deg;
        double y = lat_deg;
        to_map.apply({&x, 1}, {&y, 1});
        const core::Vec3 direction = sky::Sun(sky::compute_sun(sun, &place), 1).direction();
        const double map_azimuth = std::atan2(x - c.easting, y - c.northing);
        const double sun_azimuth = std::atan2(direction.x, -direction.z);
        INFO(time_h << " h, " << true_azimuth_deg << " degrees");
        CHECK(std::abs(std::remainder(map_azimuth - sun_azimuth, 2 * det::kPi)) < 2e-5);
    }
}
