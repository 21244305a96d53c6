#pragma once

#include <string>
#include <vector>

#include "common/voxel/archive/archive_index.hpp"

namespace terravox::voxel::archive {

/// What a shard says of itself: one of several files that together become an archive. It is laid
/// out like one, with a magic of its own, holds the levels up to kSubtreeLevel of its boxes, and
/// ends with this as JSON and the XXH64 of that (docs/formats/box-archive.md).
struct Shard {
    int number = 1;  ///< 1 to `of`
    int of = 1;
    /// Identifies the conversion: shards of one archive have the same.
    std::string job;
    std::vector<std::string> damage;  ///< of the world's data, as far as was met
};

inline constexpr int kMaxShards = 100'000;

[[nodiscard]] std::string json_of(const Shard& shard);
/// Reads the end of a shard.
/// @param index of a shard
/// @throws Error when it is damaged
[[nodiscard]] Shard read_shard(ByteSource& source, const ArchiveIndex& index);

}  // namespace terravox::voxel::archive
