#pragma once

#include <optional>

#include "voxelserver/lidar/spatial_index.hpp"

namespace terravox::lidar {

/// A COPC hierarchy: the cells of all levels of its octree, each one chunk of the file.
/// Ref: Manning, Butler et al., "COPC: Cloud Optimized Point Cloud", specification 1.0, 2021.
struct CopcIndex {
    std::vector<SpatialIndex::Cell> cells;
    std::optional<PointRange> root;  ///< points of the whole file's coarsest node
};

/// @return nullopt when the file is no COPC
/// @throws Error when it says that it is, but its hierarchy does not hold the chunks of the file
/// one to one
[[nodiscard]] std::optional<CopcIndex> read_copc_index(const LasInfo& info);

/// @return where the .lax file of a point cloud would be
[[nodiscard]] std::filesystem::path lax_path(const std::filesystem::path& cloud);

/// The .lax file beside a point cloud, a quadtree of intervals of points as LAStools writes it.
/// @return nullopt when there is none
/// @throws Error when it is damaged, or does not hold the points of this file one to one
[[nodiscard]] std::optional<std::vector<SpatialIndex::Cell>> read_lax_index(const LasInfo& info);

}  // namespace terravox::lidar
