#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

namespace terravox::archive_tools {

struct PatchReport {
    std::uint64_t columns = 0;  ///< of boxes of level 0 that were replaced
    std::uint64_t kept = 0;     ///< records that were copied from the old archive
    std::uint64_t made = 0;     ///< records of the change, and those above them
    std::uint64_t holes = 0;    ///< of all levels, in the new archive
};

/// Puts changes (common/voxel/archive/change.hpp) into an archive: the columns of boxes that they
/// replace, with all coarse boxes above them. All other records are copied, not packed anew. The
/// result has the bytes of a conversion of the new data, as far as the changes hold all that has
/// changed; where data were damaged, the header counts those of the old archive, too, while it has
/// holes outside of the changes.
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
