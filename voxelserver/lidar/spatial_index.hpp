#pragma once

#include <memory>

#include "voxelserver/lidar/las_file.hpp"
#include "voxelserver/pointcloud/spatial_index.hpp"

namespace terravox::lidar {

using pointcloud::SpatialIndex;

/// Reads the index of a file: its COPC hierarchy, else the .lax file of the same name beside it. An
/// index must hold every point of the file exactly as its chunks do, and agree with a few points
/// that are looked up, or it is refused.
/// @return nullptr when the file carries none (not an error), or it has no points
/// @throws Error when it claims one that is damaged, or that belongs to another file
[[nodiscard]] std::shared_ptr<const SpatialIndex> read_spatial_index(const LasInfo& info);

}  // namespace terravox::lidar
