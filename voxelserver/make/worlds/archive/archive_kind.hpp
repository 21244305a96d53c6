#pragma once

#include "voxelserver/make/worlds/kind/world_kind.hpp"

namespace terravox::worlds {

/// A box archive of this machine.
extern const WorldKind kArchiveKind;

/// The http:// or https:// address of a box archive.
extern const WorldKind kRemoteArchiveKind;

}  // namespace terravox::worlds
