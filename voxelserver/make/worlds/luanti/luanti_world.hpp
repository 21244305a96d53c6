#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>

#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/world_kind.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"

namespace terravox::luanti {

/// The parts of a world that are read.
struct WorldFiles {
    std::filesystem::path map;  ///< map.sqlite
    std::string title;          ///< world.mt's, else the name of the folder
    std::string game;           ///< world.mt's gameid; may be empty
};

/// Whether `path` is a world's folder (it has a world.mt, and no level.dat of Minecraft), or a file
/// named map.sqlite. Never throws.
[[nodiscard]] bool looks_like_luanti(const std::filesystem::path& path) noexcept;

/// @param path as looks_like_luanti()
/// @throws UsageError for a world whose map is not in an SQLite file, or has blocks of another
/// size; Error when world.mt cannot be read
[[nodiscard]] WorldFiles find_world_files(const std::filesystem::path& path);

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

/// How many map blocks describe() decodes at most; where there are more, a subset spread evenly.
inline constexpr std::size_t kMaxDescribedBlocks = std::size_t{1} << 20;

/// Format, counts, extent and damage of a world, in the game's own coordinates.
/// @throws UsageError when blocks are to be counted, and as find_world_files(); Error when the map
/// cannot be read
[[nodiscard]] worlds::Description describe(const worlds::DescribeRequest& request,
                                           const minecraft::BlockTable& nodes);

}  // namespace terravox::luanti

namespace terravox::worlds {

/// A world of Luanti (formerly Minetest): its folder, or the file map.sqlite in it.
extern const WorldKind kLuantiKind;

}  // namespace terravox::worlds
