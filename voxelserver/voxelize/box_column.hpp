#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <unordered_set>
#include <vector>

#include "common/voxel/box.hpp"
#include "voxelserver/voxelize/cell_store.hpp"
#include "voxelserver/voxelize/coverage.hpp"
#include "voxelserver/voxelize/deck_finder.hpp"
#include "voxelserver/voxelize/lidar_world.hpp"
#include "voxelserver/voxelize/point_set.hpp"
#include "voxelserver/voxelize/serialize.hpp"
#include "voxelserver/voxelize/surface.hpp"
#include "voxelserver/voxelize/vegetation_fill.hpp"
#include "voxelserver/voxelize/wide_ground.hpp"

namespace terravox::voxelize {

/// The boxes of one column of boxes, bottom first. They share every step but the last.
struct BoxColumn {
    std::int32_t by_begin = 0;
    voxel::Reach reach;  ///< of every patch that was looked at
    std::vector<std::shared_ptr<const voxel::Box>> boxes;
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
    static constexpr double kWidestGap_m =
        31;  ///< half of a void that is still a gap between points; at most 31 voxels

    /// @param memory_bytes for what looking for water and for the ground of wide gaps remembers
    BoxColumnMaker(PointSet& points, const imagery::Orthophotos* images, const Settings& settings,
                   std::size_t memory_bytes, util::StageTimes& times);

    [[nodiscard]] BoxColumn make(PatchKey patch);
    /// Heights of the ground, index z * 64 + x; NaN where there is none.
    [[nodiscard]] std::vector<float> ground_heights(PatchKey patch);
    [[nodiscard]] std::vector<Tree> trees(PatchKey patch);
    /// Columns inside some file's bounds in which nothing is, of the patches made so far; each
    /// counts once.
    [[nodiscard]] std::uint64_t hole_columns() const noexcept { return m_hole_columns; }

private:
    /// What the first steps find out.
    struct Land {
        Margined<char> covered;
        WaterColumns water;
        GroundHeights ground;
        std::unique_ptr<const FoundDecks> decks;  ///< that no class names; nullptr = none
        voxel::Reach reach;
    };
    [[nodiscard]] Land land_of(const Window& window);
    [[nodiscard]] Margined<Crown> crowns_of(const Window& window, const Land& land);
    template <class Work>
    auto timed(const char* name, const Work& work) {
        const util::StageTimes::Scope scope(m_times, name);
        return work();
    }

    PointSet& m_points;
    const Settings& m_settings;
    util::StageTimes& m_times;
    double m_voxel_m;
    SurfaceStep m_surface;
    CellStore m_cells;
    water::WaterBodies m_bodies;
    WideGround m_wide_ground;
    std::atomic<std::uint64_t> m_hole_columns{0};
    std::mutex m_holes_mutex;  ///< guards m_with_holes
    std::unordered_set<PatchKey, PatchKeyHash>
        m_with_holes;  ///< counted already: a patch is made again when no cache has kept it
};

}  // namespace terravox::voxelize
