#pragma once

#include <bitset>
#include <cstddef>
#include <mutex>
#include <span>
#include <vector>

#include "voxelserver/data/store/square.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/points/placer.hpp"

namespace terravox::voxelize {

/// Logs warnings about decoded points: stray points, and classes that the table does not name. Each
/// warning is logged once per file. Thread-safe.
class LoadReport {
public:
    /// Both must outlive this.
    LoadReport(std::span<const SquareSource> files, const ClassTable& classes);

    /// A file was decoded whole, or scanned. Only the first call for a file counts.
    void add_whole(std::size_t file, const store::PointCounts& counts);

    /// A part of a file was decoded. Parts are decoded in the order of the requested boxes, some of
    /// them twice: so the log names what was found without a count, and counts() does not change.
    void add_part(std::size_t file, const store::PointCounts& counts);

    /// The sum over all files for which add_whole() was called.
    [[nodiscard]] store::PointCounts counts() const;

private:
    /// What was logged about a file. All members except the first are guarded by m_mutex.
    struct Logged {
        std::once_flag whole;
        bool stray = false;
        std::bitset<256> classes;
    };

    const std::span<const SquareSource> m_files;
    const ClassTable& m_classes;
    std::vector<Logged> m_logged;
    mutable std::mutex m_mutex;
    store::PointCounts m_counts;
};

}  // namespace terravox::voxelize
