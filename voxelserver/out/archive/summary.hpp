#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/out/archive/archive_files.hpp"

namespace terravox::archive_tools {

/// What an archive's index says of one level.
struct LevelSummary {
    std::uint64_t boxes = 0;
    std::uint64_t holes = 0;
    std::uint64_t bytes = 0;  ///< of the frames of its boxes
};

/// Which of the shards of an archive a file is.
struct ShardNumber {
    int number = 0;
    int of = 0;  ///< 0: none, it is an archive
};

/// What an archive, or a shard or change of one, holds, by header, facts and index alone: boxes are
/// not read.
struct Summary {
    std::uint64_t file_bytes = 0;
    ShardNumber shard;
    std::optional<std::uint64_t> replaced_columns;  ///< of boxes, of a change; else nullopt
    std::uint32_t damage = 0;          ///< damaged places of the data that it was made from
    std::vector<LevelSummary> levels;  ///< the finest first
    std::string facts;                 ///< JSON, as `GET /v2/world` returns
    [[nodiscard]] std::uint64_t holes() const noexcept;
};

/// @throws Error when it is not an archive, or is unfinished or damaged
[[nodiscard]] Summary summary_of(const ArchiveFiles& archive);

/// The summary in lines for people.
[[nodiscard]] std::string text_of(const Summary& summary);
/// The same as a JSON object: `bytes`, `damage`, of a shard `shard` and `shards`, of a change
/// `replaced_columns`, `levels` (with
/// `boxes`, `holes`, `bytes` each) and `world`, the facts.
[[nodiscard]] std::string json_of(const Summary& summary);

}  // namespace terravox::archive_tools
