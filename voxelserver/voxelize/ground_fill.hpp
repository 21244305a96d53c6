#pragma once

#include <cstdint>

#include "voxelserver/voxelize/terrain_grid.hpp"
#include "voxelserver/voxelize/window.hpp"

namespace terravox::voxelize {

/// Steps "k-d tree (ground)" and "ground fill": the height of the ground in every column, in voxels.
///
/// A column with ground points keeps their median. Others are interpolated from the nearest ground columns within 32 voxels;
/// where there are none (wide voids), the data set's coarse terrain answers.
/// @param x0, z0 of the middle patch's first column, voxels relative to the base
/// Ref: Franke & Nielson, "Smooth interpolation of large sets of scattered data", 1980 (weights that vanish at the farthest
/// neighbour, so that it does not matter which of several equally far ones were taken).
[[nodiscard]] Margined<float> fill_ground(const Window& window, const TerrainGrid& terrain, std::int32_t x0, std::int32_t z0);

}  // namespace terravox::voxelize
