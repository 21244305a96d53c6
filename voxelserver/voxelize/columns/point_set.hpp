#pragma once

#include <atomic>
#include <bitset>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "common/util/cache.hpp"
#include "common/util/stage_times.hpp"
#include "voxelserver/voxelize/columns/columns.hpp"
#include "voxelserver/voxelize/columns/window.hpp"
#include "voxelserver/voxelize/points/point_parts.hpp"
#include "voxelserver/voxelize/points/square_info.hpp"

namespace terravox::voxelize {

/// The points of all files, by patch, decoded when needed and kept under a byte limit. Thread-safe
/// once made.
///
/// A file is decoded whole the first time, and kept in memory and in the cache folder. Where an
/// index tells which of its points lie where (COPC, .lax, or what was learnt when it was decoded
/// before), first only the part around the patch is decoded, so that the first boxes need not wait;
/// once half a file has been decoded that way, the whole is. A file too large to be kept whole is
/// always read in parts. All ways give the same points.
class PointSet {
public:
    PointSet(const LidarWorldOptions& options, const Settings& settings, util::StageTimes& times);

    [[nodiscard]] const Sources& sources() const noexcept { return m_sources; }
    [[nodiscard]] const ClassTable& classes() const noexcept { return m_classes; }
    [[nodiscard]] int cell_voxels() const noexcept {
        return m_cell_voxels;
    }  ///< edge of a water cell

    /// The columns of a patch. Never nullptr. @throws Error for a damaged file
    [[nodiscard]] std::shared_ptr<const PatchColumns> columns(grid::PatchKey key);
    /// The same for a patch and its eight neighbours.
    [[nodiscard]] Window window(grid::PatchKey middle);

    /// Which columns of a patch's window lie inside the stated bounds of some file: elsewhere there
    /// is nothing, not even rock.
    [[nodiscard]] Grid<char, Window::kMargin> in_bounds(grid::PatchKey middle) const;

    /// How far a file has come, and why it failed.
    [[nodiscard]] std::pair<SquareState, std::string> state_of(std::size_t file) const;

    /// Of all squares that have been decoded whole so far.
    [[nodiscard]] store::PointCounts counts() const;

private:
    /// A file with what is known of it so far.
    struct Entry {
        PartedFile file;
        std::string failed;  ///< why it could not be decoded: a damaged file is not tried again.
                             ///< Guarded by m_loading
        std::once_flag reported;
        bool told_wild = false;  ///< guarded by m_counts_mutex, as is the next
        std::bitset<256> told_class;
        std::weak_ptr<const store::Square>
            in_memory;           ///< guarded by m_counts_mutex, as is the next
        std::string last_error;  ///< of reading it whole or in parts
        std::atomic<bool> looked_through{
            false};  ///< its prepared square on disk was found whole in this run
    };

    /// Squares in use, by file: a caller that needs several patches keeps them, so that they are
    /// there even when no cache can hold them.
    using Held = std::map<std::size_t, Squares>;
    /// @param wanted all patches that the caller is about to ask for
    [[nodiscard]] std::shared_ptr<const PatchColumns> columns(grid::PatchKey key,
                                                              const grid::PatchRect& wanted,
                                                              Held& held);
    [[nodiscard]] Squares squares_around(std::size_t file, const grid::PatchRect& wanted);
    [[nodiscard]] Squares read_around(std::size_t file, const grid::PatchRect& wanted);
    [[nodiscard]] std::shared_ptr<const store::Square> whole(std::size_t file);
    /// How memory is dealt out between squares and parts, bytes.
    struct Shares {
        std::size_t squares, parts;
    };
    [[nodiscard]] static Shares share_out(std::size_t memory_bytes, const Sources& sources);
    void plan_files();
    [[nodiscard]] bool in_bounds(std::int32_t x, std::int32_t z) const noexcept;
    [[nodiscard]] bool surrounds(
        const grid::ColumnRect& rect) const noexcept;  ///< some file's bounds hold all of it
    void report(std::size_t file, const store::PointCounts& counts);
    void report_part(std::size_t file, const store::PointCounts& counts);
    [[nodiscard]] LoadContext context() const {
        return {m_sources.frame, m_classes, m_settings, m_times};
    }

    const Settings& m_settings;
    util::StageTimes& m_times;
    ClassTable m_classes;
    int m_threads;
    Sources m_sources;
    int m_cell_voxels = 1;
    Shares m_shares;
    std::unique_ptr<store::SquareFolder> m_folder;
    std::vector<std::unique_ptr<Entry>> m_entries;
    std::shared_ptr<const PatchColumns> m_empty;  ///< a patch inside the bounds without a point
    util::Cache<std::size_t, store::Square> m_squares;
    std::unique_ptr<PointParts> m_parts;
    util::Cache<grid::PatchKey, PatchColumns, grid::PatchKeyHash> m_columns;
    std::mutex m_loading;  ///< held while a whole square is decoded
    mutable std::mutex m_counts_mutex;
    store::PointCounts m_counts;
};

}  // namespace terravox::voxelize
