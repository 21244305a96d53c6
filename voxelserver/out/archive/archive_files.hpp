#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/voxel/archive/byte_source.hpp"

namespace terravox::archive_tools {

struct Verification;

/// An archive that lies in one file, or in parts of it (split.hpp).
class ArchiveFiles {
public:
    /// Not explicit: most archives are one file.
    ArchiveFiles(std::filesystem::path file) : m_files{std::move(file)} {}
    /// @param parts in their order; not empty
    explicit ArchiveFiles(std::vector<std::filesystem::path> parts) : m_files(std::move(parts)) {}

    /// @throws Error when a file is not there
    [[nodiscard]] std::unique_ptr<voxel::archive::ByteSource> open() const;
    /// @throws Error
    [[nodiscard]] std::uint64_t bytes() const;

private:
    std::vector<std::filesystem::path> m_files;
};

/// Whether a file is the first part of an archive: begins like one, and ends before its end.
[[nodiscard]] bool is_first_part(const std::filesystem::path& file);

/// Joins the parts of an archive again, and verifies all checksums before it appears under its
/// name.
/// @param parts in their order
/// @param out may be a symbolic link, which is followed
/// @return what was verified: no problems
/// @throws Error when a part is missing, damaged or not in its place, or the archive cannot be
/// written
Verification join_parts(const std::vector<std::filesystem::path>& parts,
                        const std::filesystem::path& out, int threads);

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
[[nodiscard]] Summary make_summary(const ArchiveFiles& archive);

/// The summary in lines for people.
[[nodiscard]] std::string to_text(const Summary& summary);
/// The same as a JSON object: `bytes`, `damage`, of a shard `shard` and `shards`, of a change
/// `replaced_columns`, `levels` (with
/// `boxes`, `holes`, `bytes` each) and `world`, the facts.
[[nodiscard]] std::string to_json(const Summary& summary);

}  // namespace terravox::archive_tools
