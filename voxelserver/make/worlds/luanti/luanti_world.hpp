#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>

#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"

namespace terravox::luanti {

struct LuantiWorldOptions {
    std::filesystem::path path;  ///< a world's folder, or its map.sqlite
    /// For boxes and decoded blocks together, at least 16 MiB.
    std::size_t memory_bytes = std::size_t{512} << 20;
    int threads = 0;  ///< that scan the blocks at opening; 0 = one for each core
    /// How many blocks are decoded before the first box, for some seconds at most. Where there are
    /// more, the bounds come from the keys of all blocks, and the framed bounds from a part of the
    /// blocks.
    std::size_t max_surveyed = std::size_t{1} << 15;
};

/// A world of Luanti (Minetest) as voxels of 1 m: node (x, y, z) is voxel (x, y, -1 - z).
/// Thread-safe, and reads blocks as boxes need them: memory does not grow with the world.
///
/// A block that the world does not have is air. One that is damaged is air and a line of damage().
/// @param nodes maps node names to materials and colours; copied
/// @throws UsageError for options out of range, a world without blocks, or one whose map is not in
/// an SQLite file; Error when nothing of it can be read
[[nodiscard]] std::unique_ptr<voxel::World> open_luanti_world(const LuantiWorldOptions& options,
                                                              const minecraft::BlockTable& nodes);

}  // namespace terravox::luanti
