#pragma once

#include "voxelserver/make/worlds/kind/world_kind.hpp"

namespace terravox::worlds {

/// A Minecraft world of the Java edition: folder, ZIP, region or chunk.
extern const WorldKind kMinecraftKind;

}  // namespace terravox::worlds
