#include "common/geo/sun_position.hpp"

#include <cmath>

#include "common/util/det_math.hpp"

namespace terravox::geo {
namespace {

constexpr double kRad = det::kPi / 180;

double wrap_deg(double a) {
    return a - 360 * std::floor(a / 360);
}

double julian_day(const DateTime& t) {
    int y = t.year;
    int m = t.month;
    if (m <= 2) {
        --y;
        m += 12;
    }
    const double a = std::floor(y / 100.0);
    const double b = 2 - a + std::floor(a / 4);
    return std::floor(365.25 * (y + 4716)) + std::floor(30.6001 * (m + 1)) + t.day + b - 1524.5 +
           (t.hour - t.utc_offset_h) / 24;
}

// Atmospheric refraction at sea level, degrees, from the true altitude (NOAA's piecewise fit).
double refraction_deg(double altitude_deg) {
    if (altitude_deg > 85)
        return 0;
    const double t = det::tan(altitude_deg * kRad);
    double seconds = 0;
    if (altitude_deg > 5)
        seconds = 58.1 / t - 0.07 / (t * t * t) + 0.000086 / (t * t * t * t * t);
    else if (altitude_deg > -0.575)
        seconds =
            1735 +
            altitude_deg *
                (-518.2 + altitude_deg * (103.4 + altitude_deg * (-12.79 + altitude_deg * 0.711)));
    else
        seconds = -20.774 / t;
    return seconds / 3600;
}

}  // namespace

SunPosition sun_position(const DateTime& time, LatLon place) noexcept {
    const double jd = julian_day(time);
    const double t = (jd - 2451545) / 36525;
    // Step 1: the sun's apparent ecliptic longitude.
    const double mean_longitude = wrap_deg(280.46646 + t * (36000.76983 + t * 0.0003032));
    const double anomaly = (357.52911 + t * (35999.05029 - 0.0001537 * t)) * kRad;
    const double centre = det::sin(anomaly) * (1.914602 - t * (0.004817 + 0.000014 * t)) +
                          det::sin(2 * anomaly) * (0.019993 - 0.000101 * t) +
                          det::sin(3 * anomaly) * 0.000289;
    const double omega = (125.04 - 1934.136 * t) * kRad;
    const double longitude = (mean_longitude + centre - 0.00569 - 0.00478 * det::sin(omega)) * kRad;
    // Step 2: to right ascension and declination.
    const double obliquity =
        (23 + (26 + (21.448 - t * (46.815 + t * (0.00059 - t * 0.001813))) / 60) / 60 +
         0.00256 * det::cos(omega)) *
        kRad;
    const double declination = det::asin(det::sin(obliquity) * det::sin(longitude));
    const double ascension =
        det::atan2(det::cos(obliquity) * det::sin(longitude), det::cos(longitude));
    // Step 3: the hour angle from sidereal time, then to the horizon.
    const double sidereal_deg = wrap_deg(280.46061837 + 360.98564736629 * (jd - 2451545) +
                                         t * t * (0.000387933 - t / 38710000));
    const double hour_angle = (sidereal_deg + place.lon_deg) * kRad - ascension;
    const double lat = place.lat_deg * kRad;
    const double altitude =
        det::asin(det::sin(lat) * det::sin(declination) +
                  det::cos(lat) * det::cos(declination) * det::cos(hour_angle)) /
        kRad;
    const double azimuth =
        det::atan2(det::sin(hour_angle),
                   det::cos(hour_angle) * det::sin(lat) - det::tan(declination) * det::cos(lat)) /
        kRad;
    return {.altitude_deg = altitude + refraction_deg(altitude),
            .azimuth_deg = wrap_deg(azimuth + 180)};
}

double solar_zone_offset_h(double lon_deg) noexcept {
    return std::round(lon_deg / 15);
}

}  // namespace terravox::geo
