#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

namespace terravox::archive_tools {

struct MergeReport {
    std::uint64_t records = 0;
    std::uint64_t holes = 0;  ///< of all levels
};

/// Joins the shards of one conversion, all of them, to the archive that the conversion without
/// shards would have made, byte for byte. Records are copied, not packed anew; only the levels
/// above the shards' are made. The shards stay.
///
/// Memory: that of voxel::ArchiveWriter, and 32 bytes a box of one shard at a time.
/// @param shards in any order
/// @param out may be a symbolic link, which is followed
/// @param threads 0: one for each core
/// @param progress called with the bytes that were copied, and all of them
/// @throws UsageError when a shard is missing, given twice, or of another conversion; Error when
/// one is damaged, or the archive cannot be written: nothing appears under its name then
MergeReport merge(std::span<const std::filesystem::path> shards, const std::filesystem::path& out,
                  int threads = 0,
                  const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

}  // namespace terravox::archive_tools
