#pragma once

#include <string>

#include "common/geo/sun_position.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::sky {

/// The sun's disc: its position, how much of it is above the horizon, and how its light is
/// distributed over it. Immutable.
class Sun {
public:
    /// @param at its azimuth from the map's north
    /// @param size times the true radius, >= 0; 0: a point, which rises and sets as the true disc
    /// does
    Sun(const geo::SunPosition& at, double size);

    /// Direction to its centre; x east, y up, z south.
    [[nodiscard]] core::Vec3 direction() const noexcept { return m_direction; }
    [[nodiscard]] double altitude_rad() const noexcept { return m_altitude_rad; }
    [[nodiscard]] double radius_rad() const noexcept { return m_radius_rad; }
    /// Share of the disc above a level horizon, [0, 1]; continuous.
    [[nodiscard]] double share_up() const noexcept { return m_share_up; }
    /// Altitude of the middle of the visible part; >= 0 while any of it is visible.
    [[nodiscard]] double seen_altitude_rad() const noexcept { return m_seen_altitude_rad; }
    /// Samples a direction of the disc, uniformly over solid angle.
    /// @param u, v [0, 1)
    [[nodiscard]] core::Vec3 sample(double u, double v) const noexcept;
    /// Radiance from a direction of unit length, as a multiple of the radiance of a white surface
    /// that faces the whole disc. Limb darkening is included; 0 outside the disc and below the
    /// horizon. Ref: Allen, "Astrophysical quantities", 1973 (linear limb darkening, coefficient
    /// 0.6 in yellow light).
    [[nodiscard]] double disc(core::Vec3 d) const noexcept;

private:
    core::Vec3 m_direction, m_right, m_up;  ///< right and up span the disc
    /// m_height: 1 - cosine of the radius.
    double m_altitude_rad;
    double m_radius_rad;
    double m_share_up;
    double m_seen_altitude_rad;
    double m_height = 0;
};

/// The sun of a scene at a place, its azimuth from the map's north: altitude and azimuth if given,
/// otherwise from date, clock time and place. The clock is that of utc_offset_h, else of the zone,
/// else of the mean solar time of the place's longitude in whole hours.
/// @param place nullptr for worlds that are not georeferenced: latitude 46, longitude 14 are used
/// @throws UsageError for an impossible date or time, an unknown zone, or one angle without the
/// other
[[nodiscard]] geo::SunPosition compute_sun(
    const scene::Scene::Sun& sun, const geo::MapPlace* place,
    geo::SunPrecision precision = geo::SunPrecision::kPicture);

/// A date from its text.
/// @param field that holds it, for the message
/// @return midnight of the day, with an offset of 0
/// @throws UsageError unless it is a day of the calendar, as YYYY-MM-DD
[[nodiscard]] geo::DateTime parse_date(const std::string& text, const std::string& field);

/// The clock time of a scene's sun at a place, as compute_sun() takes it; angles that are given are
/// ignored.
/// @throws UsageError as compute_sun()
[[nodiscard]] geo::DateTime to_time(const scene::Scene::Sun& sun, const geo::MapPlace* place);

}  // namespace terravox::sky
