#include "common/geo/lat_lon.hpp"

#include <cmath>
#include <random>

#include "common/geo/crs.hpp"
#include "tests/catch.hpp"

using namespace terravox::geo;

namespace {
constexpr LatLon kBled{46.3683, 14.1146};
}

TEST_CASE("a local frame has its origin at zero and its axes east, north and up",
          "[common][geo][local_frame]") {
    const LocalFrame frame(kBled, 500);
    const auto origin = frame.to_local(kBled, 500);
    CHECK(std::abs(origin.east_m) < 1e-6);
    CHECK(std::abs(origin.north_m) < 1e-6);
    CHECK(std::abs(origin.up_m) < 1e-6);
    const auto above = frame.to_local(kBled, 600);
    CHECK(above.up_m == Approx(100).margin(1e-6));
    CHECK(std::abs(above.east_m) < 1e-6);
    // One thousandth of a degree of latitude is 111.16 m here (GRS 80, meridian radius at 46.37
    // degrees: 6 369 000 m).
    const auto north = frame.to_local({kBled.lat_deg + 0.001, kBled.lon_deg}, 500);
    CHECK(north.north_m == Approx(111.16).margin(0.05));
    CHECK(std::abs(north.east_m) < 1e-3);
    const auto east = frame.to_local({kBled.lat_deg, kBled.lon_deg + 0.001}, 500);
    CHECK(east.east_m == Approx(76.94).margin(0.05));
    // The ellipsoid falls away from the plane by d^2 / 2R: 7.9 m at 10 km.
    const auto far = frame.to_local({kBled.lat_deg + 0.09, kBled.lon_deg}, 500);
    CHECK(far.up_m == Approx(-far.north_m * far.north_m / (2 * 6.369e6)).margin(0.05));
}

TEST_CASE("places go to the local frame and back", "[common][geo][local_frame]") {
    const LocalFrame frame(kBled, 475);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> degrees(-1, 1), metres(-500, 4000);
    for (int i = 0; i < 500; ++i) {
        const LatLon place{kBled.lat_deg + degrees(random), kBled.lon_deg + degrees(random)};
        const double height_m = metres(random);
        INFO(place.lat_deg << ", " << place.lon_deg << ", " << height_m << " m");
        double height_back_m = 0;
        const LatLon back = frame.to_lat_lon(frame.to_local(place, height_m), height_back_m);
        CHECK(back.lat_deg == Approx(place.lat_deg).margin(1e-10));
        CHECK(back.lon_deg == Approx(place.lon_deg).margin(1e-10));
        CHECK(height_back_m == Approx(height_m).margin(1e-5));
    }
}

TEST_CASE("D96/TM by GeographicLib and by PROJ agree to a millimetre",
          "[common][geo][local_frame]") {
    // EPSG:4765 is D96 itself, so that no datum shift comes between the two.
    const Transform to_projected(Crs::from_text("EPSG:4765"), Crs::from_text("EPSG:3794"));
    std::mt19937 random(6);
    std::uniform_real_distribution<double> lat(45.4, 46.9), lon(13.3, 16.7);
    for (int i = 0; i < 500; ++i) {
        const LatLon place{lat(random), lon(random)};
        INFO(place.lat_deg << ", " << place.lon_deg);
        double x = place.lon_deg;
        double y = place.lat_deg;
        to_projected.apply({&x, 1}, {&y, 1});
        const Projected mine = d96tm_from_lat_lon(place);
        CHECK(std::hypot(mine.easting_m - x, mine.northing_m - y) < 0.001);
        const LatLon back = d96tm_to_lat_lon(mine);
        CHECK(back.lat_deg == Approx(place.lat_deg).margin(1e-11));
        CHECK(back.lon_deg == Approx(place.lon_deg).margin(1e-11));
    }
}
