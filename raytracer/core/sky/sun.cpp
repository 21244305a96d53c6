#include "raytracer/core/sky/sun.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/geo/time_zone.hpp"
#include "common/util/det_math.hpp"
#include "common/util/error.hpp"

namespace terravox::sky {
namespace {

constexpr double kRad = det::kPi / 180;
constexpr double kTrueRadius_rad = 0.2666 * kRad;
constexpr double kLimb = 0.6;

// Share of a circle above a line at `y` radii over its middle.
double share_above(double y) noexcept {
    y = std::clamp(y, -1.0, 1.0);
    return (det::acos(y) - y * std::sqrt(1 - y * y)) / det::kPi;
}

}  // namespace

Sun::Sun(const geo::SunPosition& at, double size) {
    m_altitude_rad = at.altitude_deg * kRad;
    m_radius_rad = std::min(kTrueRadius_rad * std::max(0.0, size), 80 * kRad);
    const auto altitude = det::sin_cos(m_altitude_rad);
    const auto azimuth = det::sin_cos(at.azimuth_deg * kRad);
    m_direction =
        core::normalized({azimuth.sin * altitude.cos, altitude.sin, -azimuth.cos * altitude.cos});
    m_right = {azimuth.cos, 0, azimuth.sin};
    m_up = core::cross(m_right, m_direction);
    const double half = det::sin(m_radius_rad / 2);
    m_height = 2 * half * half;
    const double radius = m_radius_rad > 0 ? m_radius_rad : kTrueRadius_rad;
    m_share_up = share_above(-m_altitude_rad / radius);
    // Of a disc cut by the horizon the middle lies between the horizon and the upper limb.
    m_seen_altitude_rad =
        m_altitude_rad >= radius ? m_altitude_rad : std::max(0.0, (m_altitude_rad + radius) / 2);
}

core::Vec3 Sun::sample(double u, double v) const noexcept {
    // 1 - cosine, and sine, of the angle from the centre.
    const double down = m_height * u;
    const double r = std::sqrt(down * (2 - down));
    const auto turn = det::sin_cos(2 * det::kPi * v);
    return m_direction * (1 - down) + m_right * (r * turn.cos) + m_up * (r * turn.sin);
}

double Sun::disc(core::Vec3 d) const noexcept {
    if (!(m_height > 0) || d.y < 0 || m_share_up <= 0)
        return 0;
    const core::Vec3 apart = d - m_direction;
    const double down = core::dot(apart, apart) / 2;  // 1 - cosine, with all its digits
    if (!(down < m_height))
        return 0;
    const double rim = std::sqrt(1 - down / m_height);
    return (1 - kLimb * (1 - rim)) / (1 - kLimb / 3) / (2 * m_height * m_share_up);
}

namespace {

// Of worlds that are not georeferenced.
constexpr geo::MapPlace kDefaultPlace{46, 14};

geo::DateTime to_clock(const scene::Scene::Sun& sun) {
    geo::DateTime time = parse_date(sun.date, "sun.date");
    if (!(sun.time_h >= 0 && sun.time_h <= 24))
        throw util::UsageError("place the sun: sun.time_h = " + std::to_string(sun.time_h) +
                               "; allowed: 0 to 24");
    time.hour = sun.time_h;
    return time;
}

}  // namespace

geo::DateTime parse_date(const std::string& text, const std::string& field) {
    geo::DateTime time;
    int end = 0;
    if (std::sscanf(text.c_str(), "%4d-%2d-%2d%n", &time.year, &time.month, &time.day, &end) != 3 ||
        static_cast<std::size_t>(end) != text.size())
        throw util::UsageError("place the sun: " + field + " = '" + text +
                               "'; allowed: YYYY-MM-DD");
    if (!geo::is_date(time.year, time.month, time.day))
        throw util::UsageError("place the sun: " + field + " = '" + text +
                               "' is no day of the calendar");
    time.hour = 0;
    return time;
}

geo::DateTime to_time(const scene::Scene::Sun& sun, const geo::MapPlace* place) {
    geo::DateTime time = to_clock(sun);
    const geo::MapPlace here = place != nullptr ? *place : kDefaultPlace;
    if (sun.utc_offset_h)
        time.utc_offset_h = *sun.utc_offset_h;
    else
        time.utc_offset_h = sun.zone.empty() ? geo::solar_zone_offset_h(here.lon_deg)
                                             : geo::zone_offset_h(sun.zone, time);
    return time;
}

geo::SunPosition compute_sun(const scene::Scene::Sun& sun, const geo::MapPlace* place,
                             geo::SunPrecision precision) {
    if (sun.altitude_deg.has_value() != sun.azimuth_deg.has_value())
        throw util::UsageError(std::string("place the sun: sun.") +
                               (sun.altitude_deg ? "azimuth_deg" : "altitude_deg") +
                               " is missing; give both, or none to use date and time");
    if (sun.altitude_deg)
        return {*sun.altitude_deg, *sun.azimuth_deg};
    return geo::sun_on_map(to_time(sun, place), place != nullptr ? *place : kDefaultPlace,
                           precision);
}

}  // namespace terravox::sky
