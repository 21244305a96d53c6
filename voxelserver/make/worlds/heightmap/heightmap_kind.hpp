#pragma once

#include "voxelserver/make/worlds/kind/world_kind.hpp"

namespace terravox::worlds {

/// Rasters of heights, or folders of them.
extern const WorldKind kHeightmapKind;

}  // namespace terravox::worlds
