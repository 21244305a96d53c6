#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/voxel/archive/archive_format.hpp"
#include "common/voxel/world.hpp"

namespace terravox::voxel {

/// Writes a box archive: first into FILE.part, which gets its index and its name at finish(). What
/// was added before a break can be taken over. Not thread-safe. The bytes are a function of what is
/// added, in its order.
class ArchiveWriter {
public:
    /// @param info the world that the archive will say it is
    /// @param keep take over the records of a FILE.part that begins with the same info, up to this
    /// offset; 0: begin anew
    /// @throws Error when the file cannot be written, or what is to be kept is not there
    ArchiveWriter(std::filesystem::path file, const WorldInfo& info, std::uint64_t keep);
    ~ArchiveWriter();
    ArchiveWriter(const ArchiveWriter&) = delete;
    ArchiveWriter& operator=(const ArchiveWriter&) = delete;

    /// @param frame a zstd frame (compress()), or why the box could not be had
    void add(const BoxKey& key, archive::Kind kind, std::span<const std::byte> frame);
    /// What was added is on its way to the disk. @return where the next record goes
    std::uint64_t flush();
    /// The entries so far, in the order of adding.
    [[nodiscard]] const std::vector<archive::Entry>& entries() const noexcept { return m_entries; }
    /// The frame of an entry, read back. @throws Error
    [[nodiscard]] std::vector<std::byte> frame_of(const archive::Entry& entry) const;
    /// Writes index and header, and gives the file its name. @param damage places in which the
    /// world's data are damaged @throws Error
    void finish(std::size_t damage = 0);

private:
    void begin(const std::string& info);
    void take_over(std::uint64_t keep);
    void write(std::span<const std::byte> bytes);
    void write_at(std::uint64_t offset, std::span<const std::byte> bytes);
    [[noreturn]] void fail(const char* what) const;

    const std::filesystem::path m_file, m_part;
    int m_fd = -1;
    std::uint64_t m_at = 0;  ///< written so far, with what waits
    std::vector<std::byte> m_waiting;
    std::vector<archive::Entry> m_entries;
    archive::Header m_header{};
};

}  // namespace terravox::voxel
