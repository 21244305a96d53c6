#pragma once

#include <atomic>
#include <mutex>
#include <unordered_set>
#include <vector>

#include "voxelserver/make/voxelize/steps/tree.hpp"
#include "voxelserver/make/voxelize/world/land.hpp"

namespace terravox::voxelize {

/// The boxes of one column of boxes. They share every step except the last.
struct BoxColumn : Boxes {
    voxel::InputExtent reach;  ///< of every patch that was read
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        std::size_t sum = sizeof *this;
        for (const auto& b : boxes)
            sum += b ? b->memory_bytes() : sizeof b;
        return sum;
    }
};

/// All steps in order, from points to boxes, for one patch at a time. Thread-safe.
class BoxColumnMaker {
public:
    /// @param memory_bytes for the caches of the search for water and of the ground of wide gaps
    BoxColumnMaker(PointSet& points, const imagery::Orthophotos* images, const Settings& settings,
                   std::size_t memory_bytes, util::StageTimes& times)
        : m_context(points, images, settings, memory_bytes, times), m_times(times) {}

    [[nodiscard]] BoxColumn make(grid::PatchKey patch);
    /// Heights of the ground, index z * 64 + x; NaN where there is none.
    [[nodiscard]] std::vector<float> ground_heights(grid::PatchKey patch);
    /// As BoxColumn::reach, without the boxes, and grown by the reach of all water that the patch
    /// holds or may hold.
    [[nodiscard]] voxel::InputExtent reach(grid::PatchKey patch);
    /// As reach(), of the patch with its neighbours and the water alone: no step is run.
    [[nodiscard]] voxel::InputExtent water_reach(grid::PatchKey patch);
    [[nodiscard]] std::vector<Tree> trees(grid::PatchKey patch);
    /// Number of empty columns inside some file's bounds, of the patches made so far; each counts
    /// once.
    [[nodiscard]] std::uint64_t hole_columns() const noexcept { return m_hole_columns; }
    /// Their share of the columns inside some file's bounds, 0 to 1, in what was made so far. A
    /// patch that is made twice counts twice.
    [[nodiscard]] double hole_share() const noexcept {
        const std::uint64_t all = m_seen_columns;
        return all > 0 ? static_cast<double>(m_seen_holes) / static_cast<double>(all) : 0;
    }

private:
    void count_holes(grid::PatchKey patch, std::uint64_t holes);
    [[nodiscard]] voxel::InputExtent measure_reach(Land& land) const;

    StepContext m_context;
    util::StageTimes& m_times;
    std::atomic<std::uint64_t> m_hole_columns{0};
    std::atomic<std::uint64_t> m_seen_columns{0};
    std::atomic<std::uint64_t> m_seen_holes{0};
    std::mutex m_holes_mutex;  ///< guards m_with_holes
    /// Patches that are counted already: a patch is made again when no cache has kept it.
    std::unordered_set<grid::PatchKey, grid::PatchKeyHash> m_with_holes;
};

}  // namespace terravox::voxelize
