#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "raytracer/core/shade/shading.hpp"

namespace terravox::analyse {

// A cell looks at sun and sky by fans: the directions of an analysis are cut into fans, and the end
// of one sends the next. So a wave holds one fan of a cell, however many directions there are.

/// Where the rays of a fan start.
struct FanStart {
    core::Vec3 at;  ///< level-0 voxels
    core::VoxelCoord voxel;
    int level = 0;  ///< of the voxel
    std::uint32_t sample = 0;
};
/// @param level of the voxel that holds the point
[[nodiscard]] FanStart start_at(core::Vec3 at, int level, std::uint32_t sample) noexcept;
/// The middle of the top of the voxel that a vertical ray has met.
[[nodiscard]] FanStart start_above(const walk::TracedRay& ray) noexcept;
/// Where a fan has started.
[[nodiscard]] FanStart start_of(const walk::TracedRay& fan) noexcept;

/// Number of the fan that holds a direction.
[[nodiscard]] constexpr std::uint32_t fan_of(std::size_t direction) noexcept {
    return static_cast<std::uint32_t>(direction / walk::kFanRays);
}
/// One past the last direction of the fan that begins with direction `first`, of `count` in all.
[[nodiscard]] constexpr std::size_t fan_end(std::size_t first, std::size_t count) noexcept {
    return std::min(first + walk::kFanRays, count);
}

/// Adds a fan, made where it lies.
/// @param kind of its rays
/// @param mask of its directions
/// @param stream of its directions (RayEvaluator::directions)
walk::TracedRay& add_fan(const FanStart& start, walk::RayKind kind, walk::FanMask mask,
                         std::uint32_t stream, std::vector<walk::TracedRay>& next);

/// The rays of a fan that have met nothing: no voxel, and no terrain outside of the data.
/// @param evaluator whose fan it is
[[nodiscard]] walk::FanMask free_rays(const walk::TracedRay& fan, walk::FanEnds ends,
                                      const shade::RayEvaluator& evaluator,
                                      const shade::View& view);

}  // namespace terravox::analyse
