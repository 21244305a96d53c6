#pragma once

#include <filesystem>
#include <span>

#include "common/voxel/archive/change.hpp"
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
[[nodiscard]] const OpenChange* change_of(std::span<const OpenChange> changes,
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

}  // namespace terravox::archive_tools
