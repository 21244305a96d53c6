#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/water/adjacency.hpp"

namespace terravox::water {

/// What was seen of the water's surface in one cell.
struct LevelSample {
    float level = 0;           ///< voxels; finite when weight > 0
    std::uint32_t weight = 0;  ///< returns behind it; 0: nothing was seen
};

/// One connected body.
struct Body {
    std::vector<CellPlace> places;     ///< sorted by z, then x; connected over edges
    std::vector<LevelSample> samples;  ///< as many
    std::vector<float>
        shore;  ///< mean ground heights of the cells around, voxels, finite, in any order
};

struct LevelOptions {
    double cell_m = 2;   ///< edge of a cell, metres
    double voxel_m = 1;  ///< metres per unit of level
    bool equalize =
        true;  ///< false: each cell keeps what was seen in it, others take the nearest cell's
};

/// The level of each cell, in voxels, perfectly level in a lake and falling along a river.
///
/// A lake (the middle 80 % of its returns within 0.3 m, and no stretch of cross-sections off by
/// more than 0.2 m, as a brook that runs into it would be): one level, the median of the returns.
/// Where returns are few (below 10), water stands no higher than the lowest tenth of its shore;
/// without any return it stands there. A river: cells equally far from one end form cross-sections
/// (river_sections.hpp), which are level; their levels are estimated and made to fall towards the
/// outlets (river_profile.hpp). From every cell a way (over edges and corners) leads to an outlet
/// that never rises. NaN everywhere when there is neither a sample nor a shore. The result depends
/// on the values only: pure, thread-safe.
[[nodiscard]] std::vector<float> body_levels(const Body& body, const LevelOptions& options);
[[nodiscard]] std::vector<float> body_levels(const Body& body, const Adjacency& beside,
                                             const LevelOptions& options);

/// The value below which the share `part` (0 to 1) of the values lies. @param values not empty;
/// reordered
[[nodiscard]] float quantile(std::vector<float>& values, double part);

}  // namespace terravox::water
