#pragma once

#include <cstdint>
#include <vector>

namespace terravox::voxelize {

/// One cell of a grid in which water is looked for.
struct WaterCell {
    float level = 0;      ///< mean height of the cell's water points, voxels; valid when points > 0
    std::uint32_t points = 0;
    bool open = false;    ///< no ground, building or plant was seen: void, or water
};

/// Finds water bodies: connected open cells (4-neighbours) of which at least a few hold water points. LiDAR pulses are mostly
/// swallowed by water, so the voids around scattered returns are the body. A lake becomes flat, a river keeps its slope.
/// @param cells row by row, width * height; @param cell_m edge of a cell, metres; @param voxel_m metres per unit of level
/// @return the water level of each cell in voxels, NaN where there is none
[[nodiscard]] std::vector<float> find_water_bodies(const std::vector<WaterCell>& cells, std::int32_t width, std::int32_t height, double cell_m,
                                                   double voxel_m);

}  // namespace terravox::voxelize
