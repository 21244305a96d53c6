#pragma once

#include <cstdint>
#include <vector>

namespace terravox::water {

/// The shape of the bed near the shore. Surveys do not measure it; the defaults are typical of
/// ordinary lakes and rivers.
struct Deepening {
    double slope = 0.3;        ///< metres down per metre from the shore; 0 or more
    double min_depth_m = 0.3;  ///< at the shore; in [0, max_depth_m]
    double max_depth_m = 6;    ///< however far from the shore
    int reach_voxels = 32;     ///< search distance for shores; 1 to 1024
};

/// Computes the distance of each water column to the nearest dry column, in voxels between centres,
/// exact (Euclidean) below the reach, which is also the largest value; 0 for a dry column. Columns
/// outside the mask count as water, so that values at least `reach_voxels` inside the mask do not
/// depend on its border: patches with such a margin meet without a seam.
/// @param mask row by row (width * height), not 0 = water
/// @throws Error when the mask's size is not width * height, or the reach is out of range
/// Ref: Meijster, Roerdink & Hesselink, "A general algorithm for computing distance transforms in
/// linear time", 2000 (in integers, so that it is exact; the same lower envelope of parabolas as
/// Felzenszwalb & Huttenlocher, 2012).
[[nodiscard]] std::vector<float> shore_distance(const std::vector<std::uint8_t>& mask, int width,
                                                int height, int reach_voxels);

/// Depth at a distance: slope times the distance from the waterline, which lies half a voxel before
/// the first water column's centre, clamped to [min_depth_m, max_depth_m]; 0 for distance 0 (dry).
[[nodiscard]] float depth_m(float distance_voxels, double voxel_m, const Deepening& shape) noexcept;

/// shore_distance() followed by depth_m().
/// @return depth in metres, row by row; 0 where it is dry
/// @throws Error as above, and for a shape out of range
[[nodiscard]] std::vector<float> depths_m(const std::vector<std::uint8_t>& mask, int width,
                                          int height, double voxel_m, const Deepening& shape);

}  // namespace terravox::water
