#pragma once

#include <span>

#include "voxelserver/data/pointcloud/point_source.hpp"

namespace terravox::voxelize {

/// Logs a one-line warning when files of one world measure heights from different datums: heights
/// are used as they are, so where such files meet there may be a step that is not in the land.
/// Files that name no datum are ignored.
/// @param infos each with the CRS in which its points will be read
void warn_of_mixed_datums(std::span<const pointcloud::PointCloudInfo> infos);

}  // namespace terravox::voxelize
