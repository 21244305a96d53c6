#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "common/voxel/archive/archive_format.hpp"
#include "common/voxel/world.hpp"

namespace terravox::voxel::archive {

/// The entries of an archive that is being written, which may be more than fit into memory: a part
/// of them is sorted and written to a file without a name as soon as it is large, and the parts are
/// merged in the end. Not thread-safe.
/// Ref: Knuth, "The Art of Computer Programming", volume 3, chapter 5.4, External Sorting, 1973.
class EntryRuns {
public:
    static constexpr std::size_t kRunEntries = std::size_t{1} << 20;

    /// @param near a file in whose folder there is room
    /// @param run_entries that are in memory at a time, 32 bytes each; at least 1
    explicit EntryRuns(std::filesystem::path near, std::size_t run_entries = kRunEntries)
        : m_near(std::move(near)), m_run_entries(run_entries) {}
    ~EntryRuns();
    EntryRuns(const EntryRuns&) = delete;
    EntryRuns& operator=(const EntryRuns&) = delete;

    /// @throws Error when the file cannot be written
    void add(const Entry& entry);
    [[nodiscard]] std::uint64_t size() const noexcept { return m_spilled + m_run.size(); }
    /// Calls back with all entries, in the order of an index (before()).
    /// @throws Error when the file cannot be read; what `visit` throws
    void each_sorted(const std::function<void(const Entry&)>& visit);

private:
    void spill();
    [[nodiscard]] std::string attempt() const;

    const std::filesystem::path m_near;
    const std::size_t m_run_entries;
    std::vector<Entry> m_run;
    std::uint64_t m_spilled = 0;  ///< entries in the file, in runs of m_run_entries
    int m_fd = -1;
};

}  // namespace terravox::voxel::archive

namespace terravox::voxel {

/// Writes a box archive: first to FILE.part; finish() adds the index and renames it. An interrupted
/// archive can be continued. Not thread-safe. The bytes depend only on the added records and their
/// order. Memory: half a byte a box, and up to 32 MiB; what more the index needs meanwhile lies on
/// the disk of the archive, 32 bytes a box.
class ArchiveWriter {
public:
    /// @param info the description of the world to store in the archive
    /// @param keep continue a FILE.part that begins with the same info, keeping its records up to
    /// this offset; 0: start over
    /// @throws Error when the file cannot be written, another process writes it, or the records to
    /// keep are missing
    ArchiveWriter(const std::filesystem::path& file, const WorldInfo& info, std::uint64_t keep);
    ~ArchiveWriter();
    ArchiveWriter(const ArchiveWriter&) = delete;
    ArchiveWriter& operator=(const ArchiveWriter&) = delete;

    /// @param frame a zstd frame (compress()), or the reason why the box is unavailable
    void add(const BoxKey& key, archive::Kind kind, std::span<const std::byte> frame);
    /// Writes all added records to the file; does not wait for the disk.
    /// @return the offset of the next record
    std::uint64_t flush();
    /// Entries of the records so far.
    [[nodiscard]] std::uint64_t entries() const noexcept { return m_entries.size(); }
    [[nodiscard]] std::uint64_t holes() const noexcept { return m_holes; }
    /// Those of levels of kSubtreeLevel and more, in the order in which they were added.
    [[nodiscard]] const std::vector<archive::Entry>& coarse_entries() const noexcept {
        return m_coarse;
    }
    /// Reads the frame of an entry back.
    /// @throws Error
    [[nodiscard]] std::vector<std::byte> make_frame(const archive::Entry& entry) const;
    /// The file that is written until it is finished.
    [[nodiscard]] const std::filesystem::path& unfinished_file() const noexcept { return m_part; }
    /// Writes index and header, and renames the file to its final name.
    /// @param damage number of places where the world's data are damaged
    /// @throws Error
    void finish(std::size_t damage = 0);
    /// The same for a shard (archive_parts.hpp): a file that archives are merged of.
    /// @param facts what ends the file: to_json(Shard)
    void finish_shard(const std::string& facts);
    /// The same for a change (archive_parts.hpp): a file that replaces a part of an archive.
    /// @param facts what ends the file: to_json(Change)
    void finish_change(const std::string& facts);

private:
    void finish_with_end(const char (&magic)[8], const std::string& facts);
    void write_index();
    void close(std::size_t damage);
    void open();
    void begin(const std::string& info);
    void take_over(std::uint64_t keep);
    void note(const archive::Entry& entry);
    void write(std::span<const std::byte> bytes);
    void write_at(std::uint64_t offset, std::span<const std::byte> bytes);
    [[noreturn]] void fail(const char* what) const;

    const std::filesystem::path m_file;
    const std::filesystem::path m_part;
    int m_fd = -1;
    std::uint64_t m_at = 0;  ///< bytes written so far, including those in m_waiting
    std::vector<std::byte> m_waiting;
    archive::EntryRuns m_entries;
    std::vector<archive::Entry> m_coarse;
    std::uint64_t m_holes = 0;
    archive::Header m_header{};
};

}  // namespace terravox::voxel

namespace terravox::voxel::archive {

/// Removes what a writer has written, unless it is released: nothing stays of a call that failed.
class Unfinished {
public:
    /// @param writer whose file nobody else writes
    explicit Unfinished(const ArchiveWriter& writer) : m_file(writer.unfinished_file()) {}
    ~Unfinished() {
        std::error_code ignored;
        if (!m_file.empty())
            std::filesystem::remove(m_file, ignored);
    }
    Unfinished(const Unfinished&) = delete;
    Unfinished& operator=(const Unfinished&) = delete;
    void release() noexcept { m_file.clear(); }

private:
    std::filesystem::path m_file;
};

}  // namespace terravox::voxel::archive
