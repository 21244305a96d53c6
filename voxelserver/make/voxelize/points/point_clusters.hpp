#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voxelserver/make/voxelize/points/extent.hpp"

namespace terravox::voxelize {

/// Points within about a kilometre of each other, directly or through other points.
struct PointCluster {
    std::uint64_t count = 0;
    std::array<double, 3> min{}, max{};  ///< exact, closed, file coordinates
    friend bool operator==(const PointCluster&, const PointCluster&) = default;
};

/// Decodes all points of a file.
/// @param keeps selects the points that count
/// @param unit_m metres per horizontal unit of the file
/// @return largest first; the same for every order of the points and any number of threads
/// @throws Error for a damaged file, or one whose points are strewn over more than a million
/// squares of 256 m
[[nodiscard]] std::vector<PointCluster> find_clusters(const pointcloud::PointSource& source,
                                                      const KeepsPoint& keeps, double unit_m,
                                                      int threads);

/// Removes strays: clusters of at most a hundredth of all points that either have fewer than a
/// hundred, or lie all in one place (10 m).
/// @param clusters largest first; the first stays
void drop_strays(std::vector<PointCluster>& clusters, double unit_m);

}  // namespace terravox::voxelize
