#pragma once

#include "voxelserver/make/worlds/kind/world_kind.hpp"

namespace terravox::worlds {

/// The http:// or https:// address of a voxel server.
extern const WorldKind kServerKind;

}  // namespace terravox::worlds
