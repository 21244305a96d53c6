#pragma once

#include <optional>

#include "raytracer/core/walk/walk.hpp"

namespace terravox::walk {

/// RayWalk for one ray at a time, blocking while boxes are loaded: for tests, measurements, and
/// looking up a single point. Not thread-safe.
class Walker {
public:
    /// @param cut must outlive the walker
    Walker(BlockReader& reader, const LevelCut& cut) : m_walk(reader, cut) {}

    /// The first voxel that stops the ray with t in [0, t_max].
    /// @param ray level-0 voxels
    [[nodiscard]] std::optional<Hit> first_hit(const core::Ray& ray, StopAt stop = StopAt::kSolid,
                                               double t_max = core::kFar);

    /// The same for a ray that starts on a face: `start`, of `its_level`, is the voxel it starts
    /// in, whatever rounding makes of its origin.
    [[nodiscard]] std::optional<Hit> first_hit_from(const core::Ray& ray, core::VoxelCoord start,
                                                    int its_level = 0, StopAt stop = StopAt::kSolid,
                                                    double t_max = core::kFar);

    [[nodiscard]] std::uint64_t rays() const noexcept { return m_rays; }
    [[nodiscard]] std::uint64_t steps() const noexcept { return m_walk.counts().steps; }

private:
    [[nodiscard]] std::optional<Hit> finish(core::RayState& ray, StopAt stop, double t_max);
    RayWalk m_walk;
    std::uint64_t m_rays = 0;
};

}  // namespace terravox::walk
