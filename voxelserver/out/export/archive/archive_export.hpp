#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>

#include "common/voxel/archive/coarse_levels.hpp"
#include "voxelserver/out/export/core/columns.hpp"
#include "voxelserver/out/export/core/format.hpp"
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

/// How many steps write_archive() reports to the meter.
[[nodiscard]] std::uint64_t archive_steps(const Part& part, const voxel::WorldInfo& world);

/// Writes a part of a world as a box archive (docs/formats/box-archive.md). The part's level
/// becomes level 0; the levels above are made from it. Resumes an interrupted run. The bytes depend
/// neither on threads nor on interruptions.
/// @param shard one of several: only the columns of boxes of that one, as a shard
/// (common/voxel/archive/archive_parts.hpp)
void write_archive(Job& job, const ShardChoice& shard = {});

/// The columns in whose order write_archive() writes: each holds `rows` subtrees of boxes, one
/// above the other.
struct ArchiveColumns {
    Columns columns;
    std::int32_t edge = 0;  ///< of a column, voxels of the part's level
    std::uint64_t rows = 0;
};
[[nodiscard]] ArchiveColumns archive_columns(Job& job);

/// The columns of a shard: contiguous, so that the shards one after the other are all of them.
/// @return first, and one after the last
[[nodiscard]] std::pair<std::size_t, std::size_t> columns_of_shard(const ShardChoice& shard,
                                                                   std::size_t columns);

/// Makes a column as write_archive() does, on this thread, and writes it nowhere: for estimates.
struct MadeColumn {
    std::uint64_t boxes = 0;
    std::uint64_t bytes = 0;  ///< in the file, with its part of the index
};
[[nodiscard]] MadeColumn make_archive_column(Job& job, const Columns::At& column);

/// Removes the journal of a finished archive, or shard, that a kill has left: between renaming the
/// one and removing the other. The caller knows that nobody writes it.
void remove_journal(const std::filesystem::path& out);

/// Number of subtrees that an unfinished shard, or archive, has.
/// @param name of the conversion (Job::name)
[[nodiscard]] std::size_t finished_subtrees(const std::filesystem::path& out,
                                            const std::string& name, const ShardChoice& shard);

/// Writes a change of a box archive (common/voxel/archive/archive_parts.hpp): the boxes of some
/// columns, without coarse levels, which patching makes. A run that ends early leaves nothing under
/// the change's name. The bytes do not depend on threads.
/// @param columns within the part, of its level; not empty
void write_change(Job& job, const ChangedColumns& columns);

extern const Format kArchiveFormat;

}  // namespace terravox::exports
