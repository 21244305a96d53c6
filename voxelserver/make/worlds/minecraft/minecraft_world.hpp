#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>

#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/world_kind.hpp"

namespace terravox::minecraft {

class BlockTable;

struct MinecraftWorldOptions {
    /// A world's folder, a ZIP file that holds one (also some folders deep), a folder of regions
    /// (.mca, .mcr) or of Alpha chunks (c.x.z.dat), one region file, or one chunk file.
    std::filesystem::path path;
    /// "overworld", "nether", "end", or as WorldFolder names it: "DIM7", "some_pack:moon".
    std::string dimension = "overworld";
    /// For boxes and decoded chunks together, at least 16 MiB.
    std::size_t memory_bytes = std::size_t{512} << 20;
    int threads = 0;  ///< that scan the chunks at opening; 0 = one for each core
    /// How many chunks are scanned before the first box, for a second at most. Where there are
    /// more, the world's heights come from this many spread evenly over them, together with those
    /// of the game's own worlds; blocks that then lie outside are cut off, and a line of damage().
    std::size_t max_surveyed = 8192;
};

/// Whether `path` is likely to be something that open_minecraft_world() opens. Checks names (and a
/// ZIP file's list of names); never throws.
[[nodiscard]] bool looks_like_minecraft(const std::filesystem::path& path) noexcept;

/// A Minecraft world as voxels of 1 m: Minecraft's own axes and coordinates, unless terravox.json
/// next to level.dat (docs/formats/side-car.md) states where on Earth the world lies. Thread-safe,
/// and reads chunks as boxes need them: memory does not grow with the world.
///
/// A chunk that the world does not have is air. One that is damaged, or at the place of another, is
/// air and a line of damage(): file, chunk and reason, once each. Chunks that the game had not
/// finished (proto-chunks) are shown with the blocks that they have.
/// @param blocks maps blocks to materials and colours; copied
/// @throws UsageError for a path without a world, with several, or without that dimension; Error
/// when nothing of it can be read
[[nodiscard]] std::unique_ptr<voxel::World> open_minecraft_world(
    const MinecraftWorldOptions& options, const BlockTable& blocks);

/// Fingerprint of the files that a world's boxes are made of: names, sizes and times of those with
/// chunks, of level.dat and terravox.json, and of the block table. Players, entities and other
/// files of a world, which change all the time while it is played, are not part of it. Costs one
/// stat of each file; reads none.
/// @param world as MinecraftWorldOptions::path
/// @param blocks folder of the block table
/// @throws Error naming the path that cannot be inspected
[[nodiscard]] voxel::Fingerprint file_state(const std::filesystem::path& world,
                                            const std::filesystem::path& blocks);

}  // namespace terravox::minecraft

namespace terravox::worlds {

/// A Minecraft world of the Java edition: folder, ZIP, region or chunk.
extern const WorldKind kMinecraftKind;

}  // namespace terravox::worlds
