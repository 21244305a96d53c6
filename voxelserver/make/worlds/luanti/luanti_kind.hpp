#pragma once

#include "voxelserver/make/worlds/kind/world_kind.hpp"

namespace terravox::worlds {

/// A world of Luanti (formerly Minetest): its folder, or the file map.sqlite in it.
extern const WorldKind kLuantiKind;

}  // namespace terravox::worlds
