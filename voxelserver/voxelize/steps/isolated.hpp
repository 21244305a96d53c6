#pragma once

#include <cstdint>

#include "voxelserver/voxelize/columns/window.hpp"

namespace terravox::voxelize {

/// Step "isolated points": whether a thing's voxel hangs on nothing: no other return within two
/// voxels sideways and three up and down.
/// @param x, z in [-62, 126)
[[nodiscard]] bool isolated(const Window& window, int x, int z, std::int32_t y);

}  // namespace terravox::voxelize
