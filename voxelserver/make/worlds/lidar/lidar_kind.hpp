#pragma once

#include "voxelserver/make/voxelize/points/options.hpp"
#include "voxelserver/make/worlds/kind/world_kind.hpp"

namespace terravox::worlds {

/// Files of points (pointcloud/formats), or folders of them.
extern const WorldKind kLidarKind;

/// A store that the grabber has filled.
extern const WorldKind kStoreKind;

/// All options of a world of either kind, with the files of its inputs.
/// @throws UsageError, Error for a store that cannot be read or holds nothing
[[nodiscard]] voxelize::LidarWorldOptions lidar_world_options(const WorldOptions& from);

}  // namespace terravox::worlds
