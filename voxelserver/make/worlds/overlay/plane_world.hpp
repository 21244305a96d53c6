#pragma once

#include <memory>
#include <string_view>

#include "common/voxel/world.hpp"

namespace terravox::overlay {

/// What a plane is made of.
enum class Plane { kTable, kSea };

/// Puts a world on a plane that reaches to the horizon, so that a picture of it has a ground, the
/// world's shadow on it, and haze far away. The plane's surface is the lower bound of the world:
/// what lies on it is the world, voxel by voxel. The camera frames what it framed before.
/// Thread-safe; keeps some boxes of coarse levels, up to 16 MiB.
/// @return the world itself where it has no end of its own already, or holds nothing
[[nodiscard]] std::unique_ptr<voxel::World> on_plane(std::unique_ptr<voxel::World> world,
                                                     Plane plane);

}  // namespace terravox::overlay
