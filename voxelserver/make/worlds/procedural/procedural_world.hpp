#pragma once

#include <memory>

#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/world_kind.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"

namespace terravox::procedural {

/// A world of simplex noise: seas, rivers, hills and mountains in several climates, with trees.
///
/// Unbounded within the range of coordinates: x and z in [-2^24, 2^24), where a voxel is still
/// exact in single precision and the coarsest level is one box to each side; info().framed is what
/// a camera frames, 512 x 512 columns about the origin, and the origin is placed at a scenic spot.
/// Not georeferenced: info().crs is empty. Boxes of every level are made independently: see
/// columns.hpp. Thread-safe; no state but a cache of box columns of at most 8 MiB.
/// @throws UsageError as check(). Its boxes throw UsageError for a level that it does not have, and
/// Error after stop()
[[nodiscard]] std::unique_ptr<voxel::World> open_procedural_world(const Settings& settings);

}  // namespace terravox::procedural

namespace terravox::worlds {

/// A world of noise: the input is the text "generated" or "generated:SEED".
extern const WorldKind kProceduralKind;

}  // namespace terravox::worlds
