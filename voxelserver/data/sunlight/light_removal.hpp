#pragma once

#include <vector>

#include "voxelserver/data/sunlight/light_blend.hpp"
#include "voxelserver/data/sunlight/received_light.hpp"

namespace terravox::sunlight {

/// Inner cells next to the margin that get no albedo, as not all around them is known.
inline constexpr int kEdgeReach = kMaxCompareReach + kSurfaceEdge;

/// The photograph without sun, shadow and sky: albedo, linear, not yet clamped.
///
/// Where the surface says lit or in shadow, the light follows from it. Near the edges of shadows,
/// where surface and photograph differ by up to a metre, the photograph decides: a cell receives
/// as much light as gives it an albedo that occurs around it.
/// @param surface without gaps (fill_gaps)
/// @param inner inner_cells() of the surface, photographed
/// @param light over the cells that get an albedo
/// @return of `inner`; valid for those that are shown and at least kEdgeReach away from its edges
[[nodiscard]] std::vector<Light> remove_light(const Surface& surface, const Scene& inner,
                                              const LightField& light);

}  // namespace terravox::sunlight
