#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>

#include "common/voxel/world.hpp"

namespace terravox::minecraft {

class BlockTable;

struct MinecraftWorldOptions {
    /// A world's folder, a ZIP file that holds one (also some folders deep), a folder of regions
    /// (.mca, .mcr) or of Alpha chunks (c.x.z.dat), one region file, or one chunk file.
    std::filesystem::path path;
    std::string dimension = "overworld";  ///< "overworld", "nether", "end", or as WorldFolder names
                                          ///< it: "DIM7", "some_pack:moon"
    std::size_t memory_bytes = std::size_t{512}
                               << 20;  ///< for boxes and decoded chunks together, at least 16 MiB
    int threads = 0;  ///< that look through the chunks at opening; 0 = one for each core
    /// How many chunks are looked at before the first box, for a second at most. Where there are
    /// more, this many spread evenly over them tell the world's heights, together with those of the
    /// game's own worlds; blocks that then lie outside are cut off, and a line of damage().
    std::size_t look_through = 8192;
};

/// Whether `path` is likely to be something that open_minecraft_world() opens. Looks at names (and
/// into a ZIP file's list of names); never throws.
[[nodiscard]] bool looks_like_minecraft(const std::filesystem::path& path) noexcept;

/// A Minecraft world as voxels of 1 m: Minecraft's own axes and coordinates, unless terravox.json
/// beside level.dat (docs/formats/side-car.md) says where on Earth the world lies. Thread-safe, and
/// reads chunks as boxes need them: memory does not grow with the world.
///
/// A chunk that the world does not have is air. One that is damaged, or stands where another
/// belongs, is air and a line of damage(): file, chunk and reason, once each. Chunks that the game
/// had not finished (proto-chunks) are shown with the blocks that they have.
/// @param blocks what the blocks stand for; copied
/// @throws UsageError for a path without a world, with several, or without that dimension; Error
/// when nothing of it can be read
[[nodiscard]] std::unique_ptr<voxel::World> open_minecraft_world(
    const MinecraftWorldOptions& options, const BlockTable& blocks);

}  // namespace terravox::minecraft
