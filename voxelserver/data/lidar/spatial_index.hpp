#pragma once

#include <memory>
#include <optional>

#include "voxelserver/data/lidar/las_file.hpp"
#include "voxelserver/data/pointcloud/point_source.hpp"

namespace terravox::lidar {

using pointcloud::SpatialIndex;

/// Reads the index of a file: its COPC hierarchy, else the .lax file of the same name next to it.
/// An index is refused unless it covers every point of the file exactly as its chunks do, and
/// agrees with a few points that are decoded to verify it.
/// @return nullptr when the file has no index (not an error), or no points
/// @throws Error when it has one that is damaged, or that belongs to another file
[[nodiscard]] std::shared_ptr<const SpatialIndex> read_spatial_index(const LasInfo& info);

/// A COPC hierarchy: the cells of all levels of its octree, each stored as one chunk of the file.
/// Ref: Manning, Butler et al., "COPC: Cloud Optimized Point Cloud", specification 1.0, 2021.
struct CopcIndex {
    std::vector<SpatialIndex::Cell> cells;
    std::optional<PointRange> root;  ///< points of the root node, the coarsest of the file
};

/// @return nullopt when the file is not a COPC file
/// @throws Error when it declares to be one, but its hierarchy does not match the chunks of the
/// file one to one
[[nodiscard]] std::optional<CopcIndex> read_copc_index(const LasInfo& info);

/// @return the path of the .lax file of a point cloud, whether it exists or not
[[nodiscard]] std::filesystem::path lax_path(const std::filesystem::path& cloud);

/// Reads the .lax file next to a point cloud, a quadtree of intervals of points as LAStools writes
/// it.
/// @return nullopt when there is none
/// @throws Error when it is damaged, or does not cover the points of this file one to one
[[nodiscard]] std::optional<std::vector<SpatialIndex::Cell>> read_lax_index(const LasInfo& info);

}  // namespace terravox::lidar
