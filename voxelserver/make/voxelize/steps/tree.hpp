#pragma once

#include <cstdint>

namespace terravox::voxelize {

/// A tree as the vegetation step finds it: the highest place of a crown.
struct Tree {
    std::int32_t x = 0, z = 0;  ///< its column, absolute voxels
    float top = 0, ground = 0;  ///< heights, voxels (continuous)
};

}  // namespace terravox::voxelize
