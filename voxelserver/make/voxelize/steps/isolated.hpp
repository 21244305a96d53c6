#pragma once

#include <cstdint>

#include "voxelserver/make/voxelize/columns/window.hpp"

namespace terravox::voxelize {

/// Step "isolated points": whether an object's voxel is isolated: no other return within two voxels
/// horizontally and three vertically.
/// @param x, z in [-62, 126)
[[nodiscard]] bool isolated(const Window& window, int x, int z, std::int32_t y);

}  // namespace terravox::voxelize
