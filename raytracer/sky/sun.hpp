#pragma once

#include "common/geo/sun_position.hpp"
#include "common/voxel/colour.hpp"
#include "raytracer/core/ray.hpp"
#include "raytracer/scene/scene.hpp"

namespace terravox::sky {

/// The sun's disc: where it stands, how much of it is above the horizon, and how its light is
/// spread over it. Immutable.
class Sun {
public:
    /// @param size times the true radius, >= 0; 0: a point, which rises and sets as the true disc
    /// does
    Sun(const geo::SunPosition& at, double size);

    [[nodiscard]] core::Vec3 direction() const noexcept {
        return m_direction;
    }  ///< to its centre; x east, y up, z south
    [[nodiscard]] double altitude_rad() const noexcept { return m_altitude_rad; }
    [[nodiscard]] double radius_rad() const noexcept { return m_radius_rad; }
    /// Share of the disc above a level horizon, [0, 1]; continuous.
    [[nodiscard]] double share_up() const noexcept { return m_share_up; }
    /// Where the middle of what is seen of it stands, >= 0 while anything is.
    [[nodiscard]] double seen_altitude_rad() const noexcept { return m_seen_altitude_rad; }
    /// A direction of the disc, each solid angle as likely. @param u, v [0, 1)
    [[nodiscard]] core::Vec3 sample(double u, double v) const noexcept;
    /// Radiance towards a direction of unit length, as a multiple of what a white surface sends
    /// that faces the whole disc: limb darkening included, 0 outside the disc and below the
    /// horizon. Ref: Allen, "Astrophysical quantities", 1973 (linear limb darkening, coefficient
    /// 0.6 in yellow light).
    [[nodiscard]] double disc(core::Vec3 d) const noexcept;

private:
    core::Vec3 m_direction, m_right, m_up;  ///< right and up span the disc
    double m_altitude_rad, m_radius_rad, m_share_up, m_seen_altitude_rad,
        m_height = 0;  ///< height: 1 - cosine of the radius
};

}  // namespace terravox::sky
