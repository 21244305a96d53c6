#pragma once

#include <memory>

#include "voxelserver/data/lidar/las_file.hpp"
#include "voxelserver/data/pointcloud/spatial_index.hpp"

namespace terravox::lidar {

using pointcloud::SpatialIndex;

/// Reads the index of a file: its COPC hierarchy, else the .lax file of the same name next to it.
/// An index is refused unless it covers every point of the file exactly as its chunks do, and
/// agrees with a few points that are decoded to verify it.
/// @return nullptr when the file has no index (not an error), or no points
/// @throws Error when it has one that is damaged, or that belongs to another file
[[nodiscard]] std::shared_ptr<const SpatialIndex> read_spatial_index(const LasInfo& info);

}  // namespace terravox::lidar
