#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/voxel/world.hpp"
#include "tests/bench/accuracy/area.hpp"
#include "tests/bench/accuracy/tree_tops.hpp"
#include "voxelserver/make/voxelize/world/lidar_world.hpp"

namespace terravox::bench {

/// A vertical stretch of one column with one material: voxels y0 to y1 - 1.
struct FoundRun {
    std::int16_t y0 = 0;
    std::int16_t y1 = 0;
    voxel::Material material = voxel::Material::kAir;
};

[[nodiscard]] constexpr bool is_building(voxel::Material m) noexcept {
    return voxel::is_roof(m) || m == voxel::Material::kWall;
}

/// What a world shows of an area, column by column, as runs from below. A hidden voxel is rock,
/// whatever it is part of (box format): walls and crowns are seen where air or leaves touch them.
/// Immutable, thread-safe.
class VoxelField {
public:
    /// Reads all boxes and ground heights of the area. @param world with voxels of 1 m; where its
    /// CRS has another unit, the area is in voxels @throws Error
    VoxelField(voxelize::LidarWorld& world, const Area& area, int threads);
    /// Trees by the voxelizer's own step; of a field made by hand, those that the test gives.
    [[nodiscard]] const std::vector<TreeTop>& trees() const noexcept { return m_trees; }
    void set_trees(std::vector<TreeTop> trees) { m_trees = std::move(trees); }
    /// For tests. @param runs of each column @param ground_m of each column
    VoxelField(const Area& area, const std::vector<std::vector<FoundRun>>& runs,
               std::vector<float> ground_m);

    [[nodiscard]] const Area& area() const noexcept { return m_area; }
    [[nodiscard]] std::span<const FoundRun> runs(std::size_t index) const noexcept {
        return {m_runs.data() + m_begin[index], m_begin[index + 1] - m_begin[index]};
    }
    /// Ground before quantization, metres; NaN outside the survey.
    [[nodiscard]] float ground_m(std::size_t index) const noexcept { return m_ground[index]; }

    /// One past the highest voxel that rests on the rock below without a gap; plants and water do
    /// not count.
    [[nodiscard]] std::optional<int> ground_top(std::size_t index) const noexcept;
    /// The highest run that `wanted(material)` holds for, or nullptr.
    template <class Wanted>
    [[nodiscard]] const FoundRun* highest(std::size_t index, const Wanted& wanted) const noexcept {
        const auto all = runs(index);
        for (auto run = all.rbegin(); run != all.rend(); ++run)
            if (wanted(run->material))
                return &*run;
        return nullptr;
    }
    /// The lowest such run, or nullptr.
    template <class Wanted>
    [[nodiscard]] const FoundRun* lowest(std::size_t index, const Wanted& wanted) const noexcept {
        for (const FoundRun& run : runs(index))
            if (wanted(run.material))
                return &run;
        return nullptr;
    }

private:
    void join(const std::vector<std::vector<FoundRun>>& columns);

    Area m_area;
    std::vector<std::size_t> m_begin;
    std::vector<FoundRun> m_runs;
    std::vector<float> m_ground;
    std::vector<TreeTop> m_trees;
};

}  // namespace terravox::bench
