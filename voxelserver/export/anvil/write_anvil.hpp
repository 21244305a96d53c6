#pragma once

#include <filesystem>
#include <string>

#include "voxelserver/export/core/job.hpp"

namespace terravox::exports::anvil {

struct AnvilOptions {
    std::filesystem::path
        blocks;  ///< folder with blocks.toml, old-blocks.toml and export.toml; empty: config/blocks
    std::string title;  ///< name of the world in the game's list; empty: the world's
};

/// Writes a part of a world as a world of Minecraft, Java edition 1.21.1, that the game opens: the
/// folder job.out with level.dat, region/, a data pack when it is higher than 384 blocks, and
/// terravox.json (voxel::SideCar). One voxel is one block; what is hidden is stone. Nothing is
/// around it. A conversion that was cut off goes on where it was. The bytes written depend on the
/// world, part and options alone. Holds a region's packed chunks at a time: some MiB, at worst as
/// much as the region's voxels.
/// @throws UsageError when the part is too high or wide, or the folder holds another world; Error
/// when something cannot be written
void write_anvil(Job& job, const AnvilOptions& options);

}  // namespace terravox::exports::anvil
