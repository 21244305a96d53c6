#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

#include "common/voxel/archive/archive_parts.hpp"
#include "voxelserver/out/archive/indexed_file.hpp"

namespace terravox::archive_tools {

struct OpenChange {
    IndexedFile file;
    voxel::archive::Change facts;
};

/// @throws UsageError when the file is no change; Error when it is damaged
[[nodiscard]] OpenChange open_change(const std::filesystem::path& path);

/// The change from which a patched archive has a box of level 0.
/// @return nullptr: none of them replaces it
[[nodiscard]] const OpenChange* find_change(std::span<const OpenChange> changes,
                                            const voxel::BoxKey& key);

/// Refuses changes of another world than that of an archive, or of another one than each other.
/// @param changes not empty
/// @throws UsageError
void check_worlds(const IndexedFile& archive, std::span<const OpenChange> changes);

/// What has not changed must be alike: an archive that was made with other options, or of data of
/// which more has changed than the changes say, would become a mixture. So the columns that a
/// change compares are compared with those of the patched archive, byte for byte; a change that
/// compares none must replace all.
/// @param replaced columns that the archive loses: those that the changes replace, and others
/// @throws UsageError; Error where a record is damaged
void check_compared(const IndexedFile& archive, std::span<const OpenChange> changes,
                    const voxel::archive::ColumnSet& replaced);

struct PatchReport {
    std::uint64_t columns = 0;  ///< of boxes of level 0 that were replaced
    std::uint64_t kept = 0;     ///< records that were copied from the old archive
    std::uint64_t made = 0;     ///< records of the change, and those above them
    std::uint64_t holes = 0;    ///< of all levels, in the new archive
};

/// Puts changes (common/voxel/archive/archive_parts.hpp) into an archive: the columns of boxes that
/// they replace, with all coarse boxes above them. All other records are copied, not packed anew.
/// The result has the bytes of a conversion of the new data, as far as the changes hold all that
/// has changed; where data were damaged, the header counts those of the old archive, too, while it
/// has holes outside of the changes.
///
/// The new archive is written next to its name and renamed, and may replace the old one: programs
/// that have the old one open go on with it. Nothing is written in place.
///
/// Memory: a byte or two a box for what is coarse, some subtrees for each thread, and up to 200 MiB
/// for parts of the indices.
/// @param changes of one state of the data, in any order; not empty
/// @param out may be a symbolic link, which is followed
/// @param threads 0: one for each core; the bytes do not depend on it
/// @param progress called with subtrees done and all of them; may throw, which ends it
/// @throws UsageError when a change is of another world, or was made with other options; Error when
/// a file is damaged, or the archive cannot be written: its name then has what it had before
PatchReport patch(const std::filesystem::path& archive,
                  std::span<const std::filesystem::path> changes, const std::filesystem::path& out,
                  int threads = 0,
                  const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

}  // namespace terravox::archive_tools
