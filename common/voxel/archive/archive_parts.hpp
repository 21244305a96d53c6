#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/voxel/archive/archive_reader.hpp"

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

[[nodiscard]] std::string to_json(const Shard& shard);
/// Reads the end of a shard.
/// @param index of a shard
/// @throws Error when it is damaged
[[nodiscard]] Shard read_shard(ByteSource& source, const ArchiveIndex& index);

/// Columns of boxes of level 0 that lie in one row, from west to east; half-open.
struct ColumnRun {
    std::int32_t bz = 0;
    std::int32_t min_bx = 0;
    std::int32_t max_bx = 0;
    friend auto operator<=>(const ColumnRun&, const ColumnRun&) = default;
};

/// Columns of boxes of level 0. Immutable; thread-safe.
class ColumnSet {
public:
    ColumnSet() = default;
    /// @param runs in any order; they may overlap
    explicit ColumnSet(std::vector<ColumnRun> runs);

    /// From north to south, then from west to east; runs neither overlap nor touch each other.
    [[nodiscard]] std::span<const ColumnRun> runs() const noexcept { return m_runs; }
    [[nodiscard]] std::uint64_t count() const noexcept;
    /// Whether a box of any level covers one of the columns.
    [[nodiscard]] bool touches(const BoxKey& key) const noexcept;

private:
    [[nodiscard]] bool touches(std::int32_t bz, std::int64_t min_bx, std::int64_t max_bx) const;

    std::vector<ColumnRun> m_runs;
};

/// What a change says of itself: a file that replaces columns of boxes of an archive, since the
/// data there have changed. It is laid out like an archive, with a magic of its own, and the facts
/// of the whole new world; holds level 0 of its columns; and ends with this as JSON and the XXH64
/// of that (docs/formats/box-archive.md).
struct Change {
    ColumnSet replaced;  ///< what the archive has there is dropped
    /// Columns that have not changed, which the archive must have alike: where it does not, it was
    /// made of other data, or with other options.
    ColumnSet compared;
    std::vector<std::string> damage;  ///< of the world's data, as far as was met
};

[[nodiscard]] std::string to_json(const Change& change);
/// Reads the end of a change.
/// @param index of a change
/// @throws Error when it is damaged
[[nodiscard]] Change read_change(ByteSource& source, const ArchiveIndex& index);

}  // namespace terravox::voxel::archive
