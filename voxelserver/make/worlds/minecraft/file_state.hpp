#pragma once

#include <filesystem>

#include "common/voxel/world.hpp"

namespace terravox::minecraft {

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
