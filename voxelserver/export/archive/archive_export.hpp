#pragma once

#include "voxelserver/export/core/format.hpp"
#include "voxelserver/export/core/job.hpp"

namespace terravox::exports {

/// How many steps write_archive() reports to the meter.
[[nodiscard]] std::uint64_t archive_steps(const Part& part, const voxel::WorldInfo& world);

/// Writes a part of a world as a box archive (docs/formats/box-archive.md). The part's level
/// becomes level 0; the levels above are made from it. Resumes an interrupted run. The bytes depend
/// neither on threads nor on interruptions.
/// @param shard one of several: only the columns of boxes of that one, as a shard
/// (common/voxel/archive/shard.hpp)
void write_archive(Job& job, const ShardChoice& shard = {});

}  // namespace terravox::exports
