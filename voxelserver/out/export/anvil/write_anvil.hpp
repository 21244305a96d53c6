#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "voxelserver/out/export/anvil/export_blocks.hpp"
#include "voxelserver/out/export/anvil/section.hpp"
#include "voxelserver/out/export/core/format.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::exports::anvil {

/// Name of the data pack that allows high worlds.
inline constexpr const char* kPackName = "terravox-height";

/// level.dat as NBT, uncompressed: a creative world that is empty around what was written, and
/// begins at noon at `spawn` (a block's coordinates).
[[nodiscard]] std::string level_dat(const std::string& title,
                                    const std::array<std::int32_t, 3>& spawn, const Place& place);

/// The files of the data pack by their path in it: for the games of 1.21 and later, each of which
/// takes its own description of the overworld from an overlay.
[[nodiscard]] std::map<std::string, std::string> height_pack(const Place& place);

struct AnvilOptions {
    /// Folder with blocks.toml, old-blocks.toml and export.toml; empty: config/blocks.
    std::filesystem::path blocks;
    /// Name of the world in the game's list; empty: that of the world, else of the folder.
    std::string title;
};

/// The file in the folder of a world that says how far a conversion has come.
inline constexpr const char* kWorldJournal = "conversion.journal";

/// @throws UsageError unless a folder is missing, empty, or holds no more than a conversion that
/// was cut off before its first region
void check_new_world(const std::filesystem::path& out);

/// The tables by which voxels become blocks: of options.blocks, or of the configuration.
/// @throws UsageError for a table that cannot be read or is wrong
[[nodiscard]] ExportBlocks load_export_blocks(const AnvilOptions& options);

/// Writes a part of a world as a world of Minecraft, Java edition 1.21.1: the folder job.out with
/// level.dat, region/, a data pack when it is higher than 384 blocks, and terravox.json
/// (voxel::SideCar). One voxel is one block; hidden voxels are stone. The surroundings are empty.
/// An interrupted conversion resumes where it stopped. The bytes written depend on the world, part
/// and options alone. Holds the packed chunks of one region in memory at a time: some MiB, at worst
/// as much as the region's voxels.
/// @throws UsageError when the part is too high or wide, or the folder holds anything else; Error
/// when something cannot be written
void write_anvil(Job& job, const AnvilOptions& options);

extern const Format kAnvilFormat;

}  // namespace terravox::exports::anvil
