#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "voxelserver/data/pointcloud/point_source.hpp"

namespace terravox::voxelize {

/// A closed rectangle in the coordinates of a file.
struct PlanRect {
    double min_x = 0;
    double min_y = 0;
    double max_x = 0;
    double max_y = 0;
};

/// Whether a point is kept: not withheld, nor of a class that is dropped.
using KeepsPoint = std::function<bool(const pointcloud::Point&)>;

/// How far a point may lie beyond its header's bounds, in units of that axis: headers are written
/// with fewer digits than points.
/// @param info with its CRS
/// @param axis 0-2
[[nodiscard]] double find_rounding(const pointcloud::PointCloudInfo& info, std::size_t axis);

/// How many of the 8 x 8 equal parts of the bounds hold a sampled point.
/// @param sample points within the bounds; those outside count for the nearest part
[[nodiscard]] std::size_t parts_met(const pointcloud::PointCloudInfo& info,
                                    std::span<const pointcloud::Point> sample);

/// Determines where the land of a file lies. A header is trusted when a sample agrees with it. When
/// it does not (points beyond the bounds, or next to none in most of them), all points are read
/// once, so that the result does not depend on their order: the bounds become those of the points,
/// without strays, and a warning is logged.
/// @param info that of the source, with its CRS; its min and max are set to the actual bounds
/// @param sample kept points, in any order
/// @param threads for reading the whole file; 0 = one for each core
/// @return the parts of the bounds that hold land, in a fixed order: the bounds, or several that
/// lie kilometres apart
/// @throws Error naming the bounds when they are invalid, or hold none of the sampled points; and
/// for a damaged file
[[nodiscard]] std::vector<PlanRect> settle_extent(const pointcloud::PointSource& source,
                                                  pointcloud::PointCloudInfo& info,
                                                  std::span<const pointcloud::Point> sample,
                                                  const KeepsPoint& keeps, int threads);

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
