#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "common/voxel/box.hpp"
#include "voxelserver/make/worlds/minecraft/voxel_chunk.hpp"

namespace terravox::minecraft {

/// The 4 x 4 chunks of a column of boxes with one more on every side; index (x + 1) + 6 (z + 1), x
/// and z in [-1, 5). nullptr: air.
using ChunkPatch = std::array<std::shared_ptr<const VoxelChunk>, 36>;

/// The box of the world's heights [256 by, 256 by + 256).
/// @param lift world height minus the file's, a multiple of 16
/// @return nullptr when it is all air
[[nodiscard]] std::shared_ptr<const voxel::Box> box_of(const ChunkPatch& patch,
                                                       const voxel::BoxKey& key, std::int32_t lift);

}  // namespace terravox::minecraft
