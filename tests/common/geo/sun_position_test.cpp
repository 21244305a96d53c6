#include "common/geo/sun_position.hpp"

#include <cmath>
#include <random>

#include "common/geo/crs.hpp"
#include "tests/catch.hpp"

using namespace terravox::geo;

namespace {

constexpr double kAllowedDeg = 0.05;  // what the header promises

double angle_between_deg(double a, double b) {
    return std::abs(std::remainder(a - b, 360.0));
}

DateTime utc(int year, int month, int day, double hour) {
    return {year, month, day, hour, 0};
}

}  // namespace

// Reference: Reda and Andreas, "Solar Position Algorithm for Solar Radiation Applications", NREL
// 2003, table A5.1 (zenith 50.11162, azimuth 194.34024; refraction there is for 820 hPa, which
// takes less than 0.01 degree off).
TEST_CASE("the sun stands where published examples say", "[common][geo][sun]") {
    // One moment by three clocks.
    const auto time = GENERATE(values<DateTime>({{2003, 10, 17, 12 + 30.5 / 60, -7},
                                                 {2003, 10, 17, 19 + 30.5 / 60, 0},
                                                 {2003, 10, 18, 4.5 + 0.5 / 60, 9}}));
    const SunPosition sun = sun_position(time, {39.742476, -105.1786});
    CHECK(std::abs(sun.altitude_deg - (90 - 50.11162)) < kAllowedDeg);
    CHECK(angle_between_deg(sun.azimuth_deg, 194.34024) < kAllowedDeg);
}

// Reference: NREL's SPA (Reda & Andreas, 2003) as PyPI pvlib 0.16.1 has it, at 1010 hPa and 12
// degrees Celsius.
TEST_CASE("analyses have the sun within a hundredth of a degree of SPA", "[common][geo][sun]") {
    struct Case {
        DateTime time;
        LatLon place;
        double altitude_deg;
        double azimuth_deg;
    };
    const auto at = [](int year, int month, int day, int h, int min, int s) {
        return utc(year, month, day, h + min / 60.0 + s / 3600.0);
    };
    const Case cases[] = {
        {at(1997, 10, 16, 22, 20, 44), {-38.193754, -107.205631}, 35.48657, 288.16932},
        {at(2026, 4, 10, 3, 6, 17), {-40.336057, 153.484672}, 38.45114, 334.75562},
        {at(2045, 12, 30, 14, 32, 16), {-70.813469, -141.722761}, 17.26295, 111.10082},
        {at(2045, 10, 24, 16, 16, 27), {-55.825676, -56.505659}, 45.32047, 343.79126},
        {at(1975, 12, 16, 10, 27, 47), {37.389309, 28.829854}, 28.99157, 187.27863},
        {at(2034, 8, 17, 13, 36, 1), {-23.008458, 16.571375}, 36.95989, 309.15004},
        {at(2048, 9, 1, 1, 26, 49), {20.226579, 170.649389}, 72.95308, 226.32506},
        {at(1988, 9, 18, 8, 45, 1), {-38.048409, 28.050871}, 46.45778, 28.51717},
        {at(1976, 6, 29, 17, 44, 20), {8.679311, -159.625806}, 17.72474, 68.31562},
    };
    for (const Case& c : cases) {
        const SunPosition sun = sun_position(c.time, c.place, SunPrecision::kAnalysis);
        INFO(c.time.year << "-" << c.time.month << "-" << c.time.day);
        CHECK(std::abs(sun.altitude_deg - c.altitude_deg) < 0.006);
        CHECK(angle_between_deg(sun.azimuth_deg, c.azimuth_deg) *
                  std::cos(c.altitude_deg * 0.0174533) <
              0.006);
        // That of pictures is another one, and near.
        const SunPosition picture = sun_position(c.time, c.place);
        CHECK(picture != sun);
        CHECK(std::abs(picture.altitude_deg - sun.altitude_deg) < 0.02);
        CHECK(angle_between_deg(picture.azimuth_deg, sun.azimuth_deg) < 0.1);
    }
}

// Reference: the instants of the equinoxes, published by the U.S. Naval Observatory ("Earth's
// seasons"), UTC to the minute. The declination is 0 then, so at a pole the sun stands on the
// horizon, lifted by the refraction there: 1735 arc seconds (NOAA).
TEST_CASE("at the equinoxes the sun stands on the horizon of both poles", "[common][geo][sun]") {
    struct Case {
        int year;
        int month;
        int day;
        int hour;
        int minute;
    };
    const auto c = GENERATE(values<Case>({{2000, 3, 20, 7, 35},
                                          {2000, 9, 22, 17, 28},
                                          {2010, 3, 20, 17, 32},
                                          {2015, 3, 20, 22, 45},
                                          {2020, 3, 20, 3, 50},
                                          {2020, 9, 22, 13, 31},
                                          {2024, 3, 20, 3, 6}}));
    const DateTime time = utc(c.year, c.month, c.day, c.hour + c.minute / 60.0);
    INFO(c.year << "-" << c.month << "-" << c.day);
    for (const double lat : {90.0, -90.0})
        CHECK(std::abs(sun_position(time, {lat, 0}).altitude_deg - 1735 / 3600.0) < kAllowedDeg);
}

TEST_CASE("from one day to the next the sun at noon rises or falls by less than half a degree",
          "[common][geo][sun]") {
    struct Case {
        DateTime day;
        DateTime next;
    };
    for (const Case& c : {Case{utc(2026, 1, 31, 11), utc(2026, 2, 1, 11)},
                          Case{utc(2026, 2, 28, 11), utc(2026, 3, 1, 11)},
                          Case{utc(2024, 2, 29, 11), utc(2024, 3, 1, 11)},
                          Case{utc(2025, 12, 31, 11), utc(2026, 1, 1, 11)}}) {
        INFO(c.next.year << "-" << c.next.month);
        const double step_deg = sun_position(c.next, {46, 15}).altitude_deg -
                                sun_position(c.day, {46, 15}).altitude_deg;
        CHECK(std::abs(step_deg) < 0.5);
    }
}

TEST_CASE("a line of the map to the sun leads to the sun", "[common][geo][sun]") {
    constexpr double kRad = 3.14159265358979323846 / 180;
    constexpr double kEast = 820'000;
    constexpr double kNorth = 5'100'000;
    const Crs crs = Crs::from_text("EPSG:32633");  // at its edge north is three degrees off
    const MapPlace place = map_place(crs, kEast, kNorth);
    for (const double hour : {5.0, 8.0, 11.0, 16.0}) {
        const double on_map = sun_on_map(utc(2024, 5, 4, hour), place).azimuth_deg * kRad;
        const LatLon there =
            to_lat_lon(crs, kEast + 100 * std::sin(on_map), kNorth + 100 * std::cos(on_map));
        const double east = (there.lon_deg - place.lon_deg) * std::cos(place.lat_deg * kRad);
        const double azimuth_deg = std::atan2(east, there.lat_deg - place.lat_deg) / kRad;
        const double wanted_deg = sun_position(utc(2024, 5, 4, hour), place).azimuth_deg;
        CHECK(angle_between_deg(azimuth_deg, wanted_deg) < 0.3);  // the Earth is no sphere
    }
}

TEST_CASE("everywhere and at any time the position is a direction", "[common][geo][sun]") {
    std::mt19937 random(11);
    const auto in = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    constexpr double kSpecialLat[] = {-90, 0, 23.44, 90};
    for (int i = 0; i < 20'000; ++i) {
        const DateTime time{1900 + static_cast<int>(random() % 201),
                            1 + static_cast<int>(random() % 12),
                            1 + static_cast<int>(random() % 28), in(0, 24),
                            static_cast<double>(static_cast<int>(random() % 25) - 12)};
        const LatLon place{i % 5 == 0 ? kSpecialLat[random() % 4] : in(-90, 90), in(-180, 180)};
        const SunPosition sun = sun_position(time, place);
        const bool fine = sun.altitude_deg >= -90.5 && sun.altitude_deg <= 90.5 &&
                          sun.azimuth_deg >= 0 && sun.azimuth_deg < 360;
        if (fine)
            continue;
        INFO(time.year << "-" << time.month << "-" << time.day << " " << time.hour << " at "
                       << place.lat_deg << ", " << place.lon_deg << ": " << sun.altitude_deg << ", "
                       << sun.azimuth_deg);
        CHECK(fine);
    }
}

TEST_CASE("refraction has no jump larger than the promised error", "[common][geo][sun]") {
    // Along one day the altitude is smooth: a step between the pieces of the refraction formula
    // would show as an uneven pace.
    const LatLon place{46, 14.5};
    double previous = sun_position(utc(2024, 6, 21, 0), place).altitude_deg;
    for (int second = 10; second < 24 * 3600; second += 10) {
        const double altitude = sun_position(utc(2024, 6, 21, second / 3600.0), place).altitude_deg;
        INFO("second " << second << ", altitude " << altitude);
        REQUIRE(std::abs(altitude - previous) < 10 * 15 / 3600.0 + kAllowedDeg);
        previous = altitude;
    }
}

TEST_CASE("solar zones are whole hours around the nearest fifteen degrees", "[common][geo][sun]") {
    struct Case {
        double lon_deg;
        double offset_h;
    };
    for (const Case c : {Case{14.5, 1}, Case{0, 0}, Case{-0.1, 0}, Case{-105.2, -7}, Case{180, 12},
                         Case{-180, -12}, Case{7.4, 0}, Case{7.6, 1}}) {
        INFO(c.lon_deg);
        CHECK(solar_zone_offset_h(c.lon_deg) == c.offset_h);
    }
}
