#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/util/cache.hpp"
#include "common/util/stage_times.hpp"
#include "voxelserver/make/voxelize/columns/columns.hpp"
#include "voxelserver/make/voxelize/columns/square_reader.hpp"
#include "voxelserver/make/voxelize/points/placer.hpp"

namespace terravox::voxelize {

/// Which columns lie inside the stated bounds of some file: elsewhere there is nothing, not even
/// rock. Coordinates are absolute voxels. Immutable, thread-safe.
class SurveyBounds {
public:
    /// @param files must outlive this
    explicit SurveyBounds(std::span<const SquareSource> files) : m_files(files) {}

    [[nodiscard]] bool contains(std::int32_t x, std::int32_t z) const noexcept {
        return std::any_of(m_files.begin(), m_files.end(),
                           [&](const SquareSource& s) { return s.on_island(x, z); });
    }

    /// Whether a single part of the bounds of some file holds the whole rectangle.
    [[nodiscard]] bool surrounds(const grid::ColumnRect& rect) const noexcept;

    /// The same as contains() for all columns of the window around a patch: 1 = inside.
    [[nodiscard]] Grid<char, Window::kMargin> around(grid::PatchKey middle) const;

private:
    const std::span<const SquareSource> m_files;
};

/// The columns of all files, by patch, made when needed and kept under a byte limit. The points
/// come from a SquareReader. Thread-safe once made.
class PointSet {
public:
    PointSet(const LidarWorldOptions& options, const Settings& settings, util::StageTimes& times);

    [[nodiscard]] const Sources& sources() const noexcept { return m_sources; }
    [[nodiscard]] const ClassTable& classes() const noexcept { return m_sources.classes; }
    /// Edge of a water cell, voxels.
    [[nodiscard]] int cell_voxels() const noexcept { return m_cell_voxels; }

    /// The columns of a patch. Never nullptr.
    /// @throws Error for a damaged file
    [[nodiscard]] std::shared_ptr<const PatchColumns> columns(grid::PatchKey key);
    /// The same for a patch and its eight neighbours.
    [[nodiscard]] Window window(grid::PatchKey middle);

    /// Which columns of a patch's window lie inside the stated bounds of some file: elsewhere there
    /// is nothing, not even rock.
    [[nodiscard]] Grid<char, Window::kMargin> in_bounds(grid::PatchKey middle) const {
        return m_bounds.around(middle);
    }

    /// The state of a file, and the error if it failed.
    [[nodiscard]] std::pair<SquareState, std::string> find_state(std::size_t file) const {
        return m_squares.find_state(file);
    }

    /// SquareReader::facts_folder()
    [[nodiscard]] store::SquareFolder* facts_folder() const noexcept {
        return m_squares.facts_folder();
    }

    /// Counts of the points of all squares that have been decoded whole so far.
    [[nodiscard]] store::PointCounts counts() const { return m_report.counts(); }

private:
    /// Squares in use, by file: a caller that needs several patches holds them, so that they stay
    /// available even when no cache can keep them.
    using Held = std::map<std::size_t, Squares>;
    /// @param wanted all patches that the caller is about to request
    [[nodiscard]] std::shared_ptr<const PatchColumns> columns(grid::PatchKey key,
                                                              const grid::PatchRect& wanted,
                                                              Held& held);
    /// @return views of the points in `held`
    [[nodiscard]] std::vector<PatchPoints> list_points(grid::PatchKey key,
                                                       const grid::PatchRect& wanted, Held& held);
    [[nodiscard]] std::shared_ptr<const PatchColumns> make_columns(
        grid::PatchKey key, const std::vector<PatchPoints>& points) const;
    void mark_covered(grid::PatchKey key, water::CellPatch& cells) const noexcept;

    util::StageTimes& m_times;
    const Sources m_sources;
    const int m_cell_voxels;
    const SurveyBounds m_bounds;
    const std::shared_ptr<const PatchColumns> m_empty;  ///< inside the bounds, without a point
    const PointMemory m_memory;
    LoadReport m_report;
    SquareReader m_squares;
    util::Cache<grid::PatchKey, PatchColumns, grid::PatchKeyHash> m_columns;
};

}  // namespace terravox::voxelize
