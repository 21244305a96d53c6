#include "raytracer/core/sky/sun.hpp"

#include <algorithm>
#include <cmath>

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

}  // namespace terravox::sky
