#pragma once

#include "raytracer/core/scene/scene.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"

namespace terravox::scene {

/// The options of a world that are part of a scene: its sections `world`, `generated` and
/// `processing`. Inputs, orthophotos and the cache folder are not part of a scene and stay empty.
[[nodiscard]] worlds::WorldOptions world_options_of(const Scene& scene);

}  // namespace terravox::scene
