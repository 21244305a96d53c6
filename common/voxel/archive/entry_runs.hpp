#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "common/voxel/archive/archive_format.hpp"

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
