#pragma once

#include "voxelserver/worlds/kind/world_kind.hpp"

namespace terravox::worlds {

/// Files of points (pointcloud/formats), or folders of them.
extern const WorldKind kLidarKind;

/// A store that the grabber has filled.
extern const WorldKind kStoreKind;

}  // namespace terravox::worlds
