#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/util/files.hpp"

namespace terravox::farm {

/// An append-only file of records: a head that identifies its contents, then records, each with
/// checksums of its own (docs/formats/checkpoints.md). A torn write affects only the end of the
/// file; damage costs the records that it hits and no others.
enum class RecordKind : std::uint32_t {
    kTile = 1,       ///< encode_tile
    kForgotten = 2,  ///< the tile is invalid from here on; no payload
    kDamage = 3,     ///< which of the world's data could not be read: lines
};

struct Record {
    RecordKind kind = RecordKind::kTile;
    std::uint32_t cell = 0;    ///< TileGrid
    std::uint64_t offset = 0;  ///< of the payload in the file
    std::uint32_t bytes = 0;   ///< of the payload
};

/// An open file and its name.
class OpenFile {
public:
    /// @param flags of open(2); O_CLOEXEC is added
    /// @throws Error "<attempt> <path>: why"
    OpenFile(std::filesystem::path path, int flags, const std::string& attempt);

    [[nodiscard]] int fd() const noexcept { return m_file.get(); }
    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }
    [[nodiscard]] std::uint64_t size() const;
    /// Reads exactly `to.size()` bytes.
    /// @throws Error where the file is shorter
    void read(std::uint64_t offset, std::span<std::byte> to) const;

private:
    std::filesystem::path m_path;
    util::Descriptor m_file;
};

inline constexpr std::size_t kRecordHead_bytes = 32;

/// The head for a new file.
/// @param text identifies the contents
[[nodiscard]] std::vector<std::byte> file_head(const std::string& text);
[[nodiscard]] std::array<std::byte, kRecordHead_bytes> record_head(
    RecordKind kind, std::uint32_t cell, std::span<const std::byte> payload) noexcept;

struct RecordScan {
    std::string text;              ///< of the head
    std::vector<Record> damaged;   ///< records whose payloads are damaged and whose heads are not
    std::uint64_t lost_bytes = 0;  ///< bytes between records in which no record could be recognised
    std::uint64_t end = 0;         ///< end of the last complete record
    std::uint64_t torn_bytes = 0;  ///< bytes after that
};

/// Reads a file from its beginning, one record at a time.
/// @param record called with each undamaged record, in the file's order; it returns false for one
/// that it cannot interpret, which then counts as damaged
/// @throws Error where the file cannot be read, is not of this kind or version, or its head is
/// damaged
[[nodiscard]] RecordScan scan_records(
    const OpenFile& file, const std::function<bool(const std::string& text, const Record&,
                                                   std::span<const std::byte> payload)>& record);

}  // namespace terravox::farm
