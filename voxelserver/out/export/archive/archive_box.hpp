#pragma once

#include <cstdint>

#include "common/voxel/archive/coarse_levels.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::exports {

/// The facts of an archive of a part of a world.
[[nodiscard]] voxel::WorldInfo archive_info(const Part& part, const voxel::WorldInfo& world);

/// Outside of these, boxes of the part hold nothing: where the part ends before the world does, a
/// box may extend beyond it. Voxels of the part's level.
[[nodiscard]] voxel::VoxelBounds archive_limits(const Part& part, const voxel::WorldInfo& world);

/// A box of level 0 of an archive.
struct ArchiveBox {
    voxel::archive::MadeBox made;
    std::uint64_t voxels = 0;  ///< that are not air
};
/// @param limits archive_limits()
/// @param key of the part's level; its own level does not matter
/// @throws Error as Job::outcome()
[[nodiscard]] ArchiveBox archive_box(Job& job, const voxel::VoxelBounds& limits,
                                     const voxel::BoxKey& key);

}  // namespace terravox::exports
