#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/data/water/water_cells.hpp"

namespace terravox::water {

/// The measured water surface in one cell.
struct LevelSample {
    float level = 0;           ///< voxels; finite when weight > 0
    std::uint32_t weight = 0;  ///< number of returns; 0: no measurement
};

/// One connected water body.
struct Body {
    std::vector<CellPlace> places;     ///< sorted by z, then x; connected over edges
    std::vector<LevelSample> samples;  ///< one for each place
    /// Mean ground heights of the surrounding cells, voxels, finite, in any order.
    std::vector<float> shore;
};

struct LevelOptions {
    double cell_m = 2;   ///< edge of a cell, metres
    double voxel_m = 1;  ///< metres per unit of level
    /// False: each cell keeps its measured level, others take that of the nearest measured cell.
    bool equalize = true;
};

/// Computes the level of each cell, in voxels: perfectly flat in a lake, falling along a river.
///
/// A lake (the middle 80 % of its returns within 0.3 m, and no stretch of cross-sections off by
/// more than 0.2 m, as a tributary brook would be) has one level, the median of the returns. With
/// few returns (below 10), the level is limited to the lowest tenth of its shore; without any
/// return it equals that. A river: cells equally far from one end form cross-sections
/// (river.hpp), which are level; their levels are estimated and made to fall towards the
/// outlets (river.hpp). From every cell there is a path (over edges and corners) to an
/// outlet that never rises. NaN everywhere when there is neither a sample nor a shore. The result
/// depends on the values only: pure, thread-safe.
[[nodiscard]] std::vector<float> body_levels(const Body& body, const LevelOptions& options);
[[nodiscard]] std::vector<float> body_levels(const Body& body, const Adjacency& adjacency,
                                             const LevelOptions& options);

/// The value below which the share `part` (0 to 1) of the values lies.
/// @param values not empty; reordered
[[nodiscard]] float quantile(std::vector<float>& values, double part);

}  // namespace terravox::water
