#pragma once

#include <span>

#include "voxelserver/pointcloud/point_source.hpp"

namespace terravox::voxelize {

/// Warns, in one line, when files of one world measure heights from different datums: heights are
/// taken as they are, so where such files meet there may be a step that is not in the land. Files
/// that name no datum take no part.
/// @param infos each with the CRS that its points will be read in
void warn_of_mixed_datums(std::span<const pointcloud::PointCloudInfo> infos);

}  // namespace terravox::voxelize
