#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace terravox::farm {

/// A file of records that only grows: a head that says of what, then records, each with checksums
/// of its own (docs/formats/checkpoints.md). What was cut short is the end of the file, what was
/// damaged costs the records that it hit and no others.
enum class RecordKind : std::uint32_t {
    kTile = 1,       ///< encode_tile
    kForgotten = 2,  ///< the tile counts for nothing from here on; no payload
    kDamage = 3,     ///< what of the world's data could not be read: lines
};

struct Record {
    RecordKind kind = RecordKind::kTile;
    std::uint32_t cell = 0;    ///< TileGrid
    std::uint64_t offset = 0;  ///< of the payload in the file
    std::uint32_t bytes = 0;   ///< of the payload
};

/// An open file that is closed with its owner.
class OpenFile {
public:
    /// @param flags of open(2), O_CLOEXEC is added @throws Error "<attempt> <path>: why"
    OpenFile(std::filesystem::path path, int flags, const std::string& attempt);
    ~OpenFile();
    OpenFile(OpenFile&& from) noexcept
        : m_path(std::move(from.m_path)), m_fd(std::exchange(from.m_fd, -1)) {}
    OpenFile& operator=(OpenFile&&) = delete;

    [[nodiscard]] int fd() const noexcept { return m_fd; }
    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }
    [[nodiscard]] std::uint64_t size() const;
    /// Exactly so many bytes. @throws Error where they are not there
    void read(std::uint64_t offset, std::span<std::byte> to) const;

private:
    std::filesystem::path m_path;
    int m_fd = -1;
};

inline constexpr std::size_t kRecordHead_bytes = 32;

/// The head of such a file, for a new one. @param text what it is of
[[nodiscard]] std::vector<std::byte> file_head(const std::string& text);
[[nodiscard]] std::array<std::byte, kRecordHead_bytes> record_head(
    RecordKind kind, std::uint32_t cell, std::span<const std::byte> payload) noexcept;

struct RecordScan {
    std::string text;              ///< of the head
    std::vector<Record> spoiled;   ///< payloads that are damaged, heads that are not
    std::uint64_t lost_bytes = 0;  ///< where no record could be made out, between others
    std::uint64_t end = 0;         ///< of the last record that is there whole
    std::uint64_t torn_bytes = 0;  ///< behind that
};

/// Reads a file from its beginning, one record at a time. @param record takes each that is not
/// damaged, in the file's order; it returns false for one that it cannot make sense of, which is
/// spoiled then
/// @throws Error where the file cannot be read, is none of this kind or of another version, or its
/// head is damaged
[[nodiscard]] RecordScan scan_records(
    const OpenFile& file, const std::function<bool(const std::string& text, const Record&,
                                                   std::span<const std::byte> payload)>& record);

}  // namespace terravox::farm
