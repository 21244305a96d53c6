#include "voxelserver/voxelize/lidar_world.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "common/util/cache.hpp"
#include "common/util/error.hpp"
#include "common/voxel/downsample.hpp"
#include "voxelserver/voxelize/building_fill.hpp"
#include "voxelserver/voxelize/ground_fill.hpp"
#include "voxelserver/voxelize/orthophoto.hpp"
#include "voxelserver/voxelize/point_set.hpp"
#include "voxelserver/voxelize/runs.hpp"
#include "voxelserver/voxelize/serialize.hpp"
#include "voxelserver/voxelize/terrain_grid.hpp"

namespace terravox::voxelize {
namespace {

using voxel::Box;
using voxel::BoxKey;

constexpr double kFloorDepth_m = 10;  // rock below the lowest ground: the model's base

/// The boxes of one column of boxes, bottom first.
struct BoxColumn {
    std::int32_t by_begin = 0;
    std::vector<std::shared_ptr<const Box>> boxes;
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        std::size_t sum = sizeof *this;
        for (const auto& b : boxes) sum += b ? b->memory_bytes() : sizeof b;
        return sum;
    }
};

class LidarWorldImpl final : public LidarWorld {
public:
    LidarWorldImpl(const LidarWorldOptions& options, util::StageTimes& times)
        : m_times(times),
          m_points(options, times),
          m_terrain(m_points.scan_terrain()),
          m_columns(options.memory_bytes / 8),
          m_coarse(options.memory_bytes / 8) {
        if (!options.orthophotos.empty()) m_ortho = std::make_unique<Orthophotos>(options.orthophotos, m_points.frame());
        const Frame& frame = m_points.frame();
        const auto& b = m_points.bounds();
        const Base base = m_points.base();
        m_floor_y = static_cast<std::int32_t>(std::floor(m_terrain.lowest() - kFloorDepth_m / frame.voxel_m()));
        m_info.title = options.files.front().stem().string();
        m_info.bounds.min = {base.x + b.min_x, m_floor_y, base.z + b.min_z};
        m_info.bounds.max = {base.x + b.max_x, static_cast<std::int32_t>(std::floor(m_terrain.highest())) + 1, base.z + b.max_z};
        m_info.voxel_m = frame.voxel_m();
        m_info.crs = frame.crs().name();
        m_info.crs_wkt = frame.crs().wkt();
        m_info.crs_units_per_voxel = frame.units_per_voxel();
        m_info.centre = geo::to_lat_lon(frame.crs(), frame.easting((m_info.bounds.min[0] + m_info.bounds.max[0]) / 2.0),
                                        frame.northing((m_info.bounds.min[2] + m_info.bounds.max[2]) / 2.0));
        // Levels until the whole world fits in a box.
        const std::int32_t widest = std::max(m_info.bounds.max[0] - m_info.bounds.min[0], m_info.bounds.max[2] - m_info.bounds.min[2]);
        while (m_info.levels < voxel::kMaxLevel && (voxel::kBoxSizeX << (m_info.levels - 1)) < widest) ++m_info.levels;
    }

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }

    [[nodiscard]] LidarWorldStats stats() const override {
        return {m_points.point_count(), m_points.wild_points(), m_points.file_count(), m_ortho ? m_ortho->count() : 0, m_terrain.cell_voxels() * m_info.voxel_m};
    }

    [[nodiscard]] std::shared_ptr<const Box> box(const BoxKey& key) override {
        check(key.level);
        if (key.level > 0) return coarse_box(key);
        if (!voxel::boxes_over(m_info.bounds, 0).contains(key)) return nullptr;
        const auto column = box_column(key.bx, key.bz);
        const std::int64_t index = std::int64_t{key.by} - column->by_begin;
        return index >= 0 && index < static_cast<std::int64_t>(column->boxes.size()) ? column->boxes[static_cast<std::size_t>(index)] : nullptr;
    }

    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        check(level);
        const auto range = voxel::boxes_over(m_info.bounds, level);
        if (bx < range.min.bx || bx >= range.max.bx || bz < range.min.bz || bz >= range.max.bz) return {};
        return {range.min.by, range.max.by};
    }

private:
    void check(int level) const {
        if (level < 0 || level >= m_info.levels) throw UsageError("make a box: level " + std::to_string(level) + "; allowed: 0 to " + std::to_string(m_info.levels - 1));
    }

    template <class Work> auto timed(const char* name, const Work& work) {
        const util::StageTimes::Scope scope(m_times, name);
        return work();
    }

    // All boxes of a patch at once: they share every step but the last.
    std::shared_ptr<const BoxColumn> box_column(std::int32_t bx, std::int32_t bz) {
        return m_columns.get(BoxKey{0, bx, 0, bz}, [&] { return make_box_column(bx, bz); }, [](const auto& c) { return c->memory_bytes(); });
    }

    std::shared_ptr<const BoxColumn> make_box_column(std::int32_t bx, std::int32_t bz) {
        const Base base = m_points.base();
        const PatchKey key{bx - base.x / kPatchSize, bz - base.z / kPatchSize};
        Window window;
        for (int dz = -1; dz <= 1; ++dz)
            for (int dx = -1; dx <= 1; ++dx) window.patches[static_cast<std::size_t>((dz + 1) * 3 + dx + 1)] = m_points.columns({key.px + dx, key.pz + dz});
        const std::int32_t x0 = key.px * kPatchSize, z0 = key.pz * kPatchSize;
        const Margined<float> ground = timed("ground fill", [&] { return fill_ground(window, m_terrain, x0, z0); });
        const Margined<Surface> roofs = timed("building fill", [&] { return close_roofs(window); });
        const PatchRuns runs = timed("underground fill", [&] {
            return make_runs({window, m_points.classes(), m_terrain, ground, roofs, m_points.surveyed(x0, z0), x0, z0, m_floor_y, m_info.voxel_m});
        });
        const PatchColours colours = m_ortho ? timed("orthophoto load", [&] { return m_ortho->colours(bx * kPatchSize, bz * kPatchSize); }) : PatchColours{};
        auto column = std::make_shared<BoxColumn>();
        if (runs.min_y() >= runs.max_y()) return column;
        const util::StageTimes::Scope scope(m_times, "serialization");
        column->by_begin = voxel::floor_div(runs.min_y(), voxel::kBoxSizeY);
        const std::int32_t end = voxel::floor_div(runs.max_y() - 1, voxel::kBoxSizeY) + 1;
        for (std::int32_t by = column->by_begin; by < end; ++by) column->boxes.push_back(serialize({0, bx, by, bz}, runs, colours));
        return column;
    }

    std::shared_ptr<const Box> coarse_box(const BoxKey& key) {
        if (!voxel::boxes_over(m_info.bounds, key.level).contains(key)) return nullptr;
        return m_coarse.get(
            key,
            [&] {
                std::array<std::shared_ptr<const Box>, 8> children;
                for (int i = 0; i < 8; ++i)
                    children[static_cast<std::size_t>(i)] = box({key.level - 1, 2 * key.bx + (i & 1), 2 * key.by + (i >> 2), 2 * key.bz + (i >> 1 & 1)});
                const util::StageTimes::Scope scope(m_times, "downsample");
                return voxel::downsample(key, children);
            },
            [](const auto& b) { return b ? b->memory_bytes() : std::size_t{0}; });
    }

    util::StageTimes& m_times;
    PointSet m_points;
    TerrainGrid m_terrain;
    std::unique_ptr<Orthophotos> m_ortho;
    std::int32_t m_floor_y = 0;
    voxel::WorldInfo m_info;
    util::Cache<BoxKey, BoxColumn, voxel::BoxKeyHash> m_columns;
    util::Cache<BoxKey, Box, voxel::BoxKeyHash> m_coarse;
};

}  // namespace

std::unique_ptr<LidarWorld> open_lidar_world(const LidarWorldOptions& options, util::StageTimes& times) {
    return std::make_unique<LidarWorldImpl>(options, times);
}

}  // namespace terravox::voxelize
