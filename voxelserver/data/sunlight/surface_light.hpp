#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/data/sunlight/sunlit.hpp"

namespace terravox::sunlight {

/// How the sun and the sky light the inner cells of a surface; index as in inner_cells() of it.
struct SurfaceLight {
    /// Share of the sun that is seen, as by Sunlit: [0, 1]. 1 where no height is known.
    std::vector<float> lit;
    std::vector<std::uint8_t> edge;  ///< 1 = near the edge of a shadow, where `lit` is not certain
    std::vector<float> facing;    ///< sunlight on its slope over that on flat ground, [0.15, 2.5]
    std::vector<float> sky_seen;  ///< share of the sky above its slope, (0.5, 1]
};

/// @param surface without gaps (fill_gaps)
/// @return `edge` is valid for cells at least kSurfaceEdge from the margin
[[nodiscard]] SurfaceLight surface_light(const Surface& surface, const Sun& sun);
inline constexpr int kSurfaceEdge = 3;

}  // namespace terravox::sunlight
