#pragma once

#include "voxelserver/worlds/kind/world_kind.hpp"

namespace terravox::worlds {

/// The http:// or https:// address of a voxel server.
extern const WorldKind kServerKind;

}  // namespace terravox::worlds
