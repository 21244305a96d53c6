#include "common/geo/sun_position.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

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

/// Where the sun is among the stars. Radians.
struct Place {
    double declination = 0;
    double ascension = 0;
    double sidereal_deg = 0;  ///< mean or apparent time of Greenwich
    double parallax = 0;      ///< of the sun at the horizon
};

/// Centuries since 2000-01-01 12:00.
double centuries(double jd) {
    return (jd - 2451545) / 36525;
}

double mean_sidereal_deg(double jd) {
    const double t = centuries(jd);
    return wrap_deg(280.46061837 + 360.98564736629 * (jd - 2451545) +
                    t * t * (0.000387933 - t / 38710000));
}

double anomaly_rad(double t) {
    return (357.52911 + t * (35999.05029 - 0.0001537 * t)) * kRad;
}

double mean_longitude_deg(double t) {
    return wrap_deg(280.46646 + t * (36000.76983 + t * 0.0003032));
}

double equation_of_centre_deg(double t) {
    const double anomaly = anomaly_rad(t);
    return det::sin(anomaly) * (1.914602 - t * (0.004817 + 0.000014 * t)) +
           det::sin(2 * anomaly) * (0.019993 - 0.000101 * t) + det::sin(3 * anomaly) * 0.000289;
}

double mean_obliquity_deg(double t) {
    return 23 + (26 + (21.448 - t * (46.815 + t * (0.00059 - t * 0.001813))) / 60) / 60;
}

Place among_stars(double longitude, double obliquity) {
    Place out;
    out.declination = det::asin(det::sin(obliquity) * det::sin(longitude));
    out.ascension = det::atan2(det::cos(obliquity) * det::sin(longitude), det::cos(longitude));
    return out;
}

Place place_for_pictures(double jd) {
    const double t = centuries(jd);
    const double omega = (125.04 - 1934.136 * t) * kRad;
    const double longitude =
        (mean_longitude_deg(t) + equation_of_centre_deg(t) - 0.00569 - 0.00478 * det::sin(omega)) *
        kRad;
    const double obliquity = (mean_obliquity_deg(t) + 0.00256 * det::cos(omega)) * kRad;
    Place out = among_stars(longitude, obliquity);
    out.sidereal_deg = mean_sidereal_deg(jd);
    return out;
}

/// Even time minus that of the Earth's rotation, seconds: observed ones, and a forecast; a second
/// is 0.00001 degree of the sun's way.
double delta_t_s(double year) {
    constexpr double kYears = 25;
    constexpr double seconds[] = {-3, 24, 29, 46, 64, 70, 80, 95, 110};
    const double at = std::clamp((year - 1900) / kYears, 0.0, 8.0);
    const auto i = std::min(static_cast<std::size_t>(at), std::size_t{7});
    return seconds[i] + (seconds[i + 1] - seconds[i]) * (at - static_cast<double>(i));
}

/// What planets and the Moon add to the longitude, degrees. @param t centuries since 2000
double perturbations_deg(double t) {
    const double c = t + 1;
    return 0.00134 * det::cos((153.23 + 22518.7541 * c) * kRad) +
           0.00154 * det::cos((216.57 + 45037.5082 * c) * kRad) +
           0.00200 * det::cos((312.69 + 32964.3577 * c) * kRad) +
           0.00179 * det::sin((350.74 + (445267.1142 - 0.00144 * c) * c) * kRad) +
           0.00178 * det::sin((231.19 + 20.20 * c) * kRad);
}

Place place_for_analyses(double jd, double year) {
    constexpr double kDay_s = 86400;
    constexpr double kSecond = 1.0 / 3600;
    const double t = centuries(jd + delta_t_s(year) / kDay_s);
    const double mean_deg = mean_longitude_deg(t);
    const double centre_deg = equation_of_centre_deg(t);
    const double omega = (125.04452 - 1934.136261 * t) * kRad;
    const double sun = 2 * mean_deg * kRad;
    const double moon = 2 * (218.3165 + 481267.8813 * t) * kRad;
    const double nutation_deg = kSecond * (-17.20 * det::sin(omega) - 1.32 * det::sin(sun) -
                                           0.23 * det::sin(moon) + 0.21 * det::sin(2 * omega));
    const double tilt_deg = kSecond * (9.20 * det::cos(omega) + 0.57 * det::cos(sun) +
                                       0.10 * det::cos(moon) - 0.09 * det::cos(2 * omega));
    const double eccentricity = 0.016708634 - t * (0.000042037 + 0.0000001267 * t);
    const double distance = 1.000001018 * (1 - eccentricity * eccentricity) /
                            (1 + eccentricity * det::cos(anomaly_rad(t) + centre_deg * kRad));
    constexpr double kAberration_deg = 20.4898 * kSecond;
    const double longitude =
        (mean_deg + centre_deg + perturbations_deg(t) + nutation_deg - kAberration_deg / distance) *
        kRad;
    const double obliquity = (mean_obliquity_deg(t) + tilt_deg) * kRad;
    Place out = among_stars(longitude, obliquity);
    out.sidereal_deg = mean_sidereal_deg(jd) + nutation_deg * det::cos(obliquity);
    out.parallax = 8.794 * kSecond / distance * kRad;
    return out;
}

}  // namespace

SunPosition sun_position(const DateTime& time, LatLon place, SunPrecision precision) noexcept {
    const double jd = julian_day(time);
    const bool is_picture = precision == SunPrecision::kPicture;
    const Place sun = is_picture ? place_for_pictures(jd) : place_for_analyses(jd, time.year);
    // From the stars to the horizon.
    const double declination = sun.declination;
    const double hour_angle = (sun.sidereal_deg + place.lon_deg) * kRad - sun.ascension;
    const double lat = place.lat_deg * kRad;
    const double from_centre =
        det::asin(det::sin(lat) * det::sin(declination) +
                  det::cos(lat) * det::cos(declination) * det::cos(hour_angle));
    const double altitude = (from_centre - sun.parallax * det::cos(from_centre)) / kRad;
    const double azimuth =
        det::atan2(det::sin(hour_angle),
                   det::cos(hour_angle) * det::sin(lat) - det::tan(declination) * det::cos(lat)) /
        kRad;
    return {.altitude_deg = altitude + refraction_deg(altitude),
            .azimuth_deg = wrap_deg(azimuth + 180)};
}

SunPosition sun_on_map(const DateTime& time, const MapPlace& place,
                       SunPrecision precision) noexcept {
    SunPosition sun = sun_position(time, place, precision);
    sun.azimuth_deg = wrap_deg(sun.azimuth_deg - place.convergence_deg);
    return sun;
}

double solar_zone_offset_h(double lon_deg) noexcept {
    return std::round(lon_deg / 15);
}

}  // namespace terravox::geo
