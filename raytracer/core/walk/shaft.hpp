#pragma once

#include <optional>

#include "raytracer/core/base/ray_state.hpp"
#include "raytracer/core/walk/solid_query.hpp"

namespace terravox::walk {

/// Rays of one direction, or of a narrow cone of directions, from origins that lie together: a
/// block of shadow rays. It covers all points between the highest and the lowest of the lines
/// through the origins, seen along the major axis of the direction. Coordinates are level-0 voxels.
class Shaft {
public:
    /// @param radius_rad of the cone, at most 0.1
    explicit Shaft(core::Vec3 direction, double radius_rad = 0) noexcept;
    /// @param ray the ray's state where it starts
    void add(const core::Vec3& origin, const core::RayState& ray) noexcept;
    [[nodiscard]] int axis() const noexcept { return m_axis; }

private:
    friend class ShaftMarch;
    /// The plane behind the ray, of the voxel that it is in.
    [[nodiscard]] std::int32_t behind(const core::RayState& ray) const noexcept {
        return (ray.voxel[m_axis] + (m_forward ? 0 : 1)) << ray.level;
    }
    int m_axis;
    bool m_forward;
    double m_slope[3];
    double m_spread;             ///< greatest deviation of a ray's slope
    double m_low[3], m_high[3];  ///< where the lines cross the plane `axis = 0`
    std::int32_t m_first;        ///< plane behind the hindmost voxel in which a ray starts
};

/// Marches shafts from where they leave the world back towards the origins.
class ShaftMarch {
public:
    ShaftMarch(BlockReader& reader, const LevelCut& cut) : m_query(reader, cut), m_cut(cut) {}
    /// @return the plane on the shaft's axis from which on (in its direction) nothing is in the way
    /// @param known the result for a shaft that encloses this one
    [[nodiscard]] std::int32_t free_from(const Shaft& shaft,
                                         std::optional<std::int32_t> known = std::nullopt);
    /// Whether a ray of the shaft starts at or beyond free_from().
    [[nodiscard]] static bool is_free(const Shaft& shaft, const core::RayState& ray,
                                      std::int32_t free_from) noexcept {
        return shaft.m_forward ? shaft.behind(ray) >= free_from : shaft.behind(ray) <= free_from;
    }
    [[nodiscard]] std::uint64_t slabs() const noexcept { return m_slabs; }

private:
    [[nodiscard]] std::int32_t find_end(const Shaft& shaft) const noexcept;
    SolidQuery m_query;
    const LevelCut& m_cut;
    std::uint64_t m_slabs = 0;
};

}  // namespace terravox::walk
