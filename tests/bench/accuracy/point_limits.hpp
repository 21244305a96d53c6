#pragma once

#include <filesystem>
#include <vector>

#include "tests/bench/accuracy/truth_place.hpp"
#include "tests/bench/bench.hpp"

namespace terravox::bench {

/// What the points of each column would allow: the limit that the data themselves set to any
/// voxelizer.
struct PointColumns {
    std::vector<std::uint16_t> points, building, bridge;  ///< how many in each column
    std::vector<float> plant_m;  ///< of the highest vegetation point; kNoWater without any
    std::vector<char> ground;    ///< 1 where a ground point lies in the column
    double ground_rmse_m = 0;    ///< of all ground points, each at its own place
};

/// Reads all points of a survey. @throws Error
[[nodiscard]] PointColumns read_point_columns(const std::vector<std::filesystem::path>& files,
                                              const TruthPlace& truth, int threads);

/// The readings that an ideal voxelizer could reach with these points. @param width as for the
/// voxels
void add_point_limits(const TruthPlace& truth, const PointColumns& points, const CrownWidth& width,
                      Readings& readings);

}  // namespace terravox::bench
