#include "voxelserver/voxelize/lidar_world.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/util/cache.hpp"
#include "common/util/error.hpp"
#include "common/voxel/downsample.hpp"
#include "voxelserver/voxelize/box_column.hpp"

namespace terravox::voxelize {
namespace {

using voxel::Box;
using voxel::BoxKey;

// How the world's memory is shared out; PointSet takes the rest (point_set.cpp).
constexpr std::size_t kColumnsShare = 10, kCoarseShare = 20, kMakerShare = 20;

class LidarWorldImpl final : public LidarWorld {
public:
    LidarWorldImpl(const LidarWorldOptions& options, util::StageTimes& times)
        : m_times(times),
          m_settings(load_settings(options.settings)),
          m_points(options, m_settings, times),
          m_images(options.orthophotos.empty() ? nullptr : std::make_unique<imagery::Orthophotos>(options.orthophotos, m_points.sources().frame)),
          m_maker(m_points, m_images.get(), m_settings, options.memory_bytes / kMakerShare, times),
          m_columns(options.memory_bytes / kColumnsShare),
          m_coarse(options.memory_bytes / kCoarseShare) {
        const Sources& sources = m_points.sources();
        const Frame& frame = sources.frame;
        if (m_images) m_images->warn_of_outside(sources.bounds);
        for (const SquareSource& s : sources.files) m_islands.insert(m_islands.end(), s.islands.begin(), s.islands.end());
        m_info.title = options.files.front().stem().string();
        m_info.bounds.min = {sources.bounds.min_x, sources.lowest_y, sources.bounds.min_z};
        m_info.bounds.max = {sources.bounds.max_x, sources.highest_y, sources.bounds.max_z};
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

    ~LidarWorldImpl() override {
        if (const auto holes = m_maker.hole_columns(); holes > 0)
            spdlog::info("{}: {} columns inside the files' bounds are holes: nothing was seen for {:.0f} m around", m_info.title, holes, BoxColumnMaker::kWidestGap_m);
    }
    LidarWorldImpl(const LidarWorldImpl&) = delete;
    LidarWorldImpl& operator=(const LidarWorldImpl&) = delete;

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }

    [[nodiscard]] LidarWorldStats stats() const override {
        const Sources& sources = m_points.sources();
        return {sources.point_count, sources.files.size(), m_images ? m_images->count() : 0, m_points.cell_voxels() * m_info.voxel_m, m_points.counts().wild,
                m_maker.hole_columns()};
    }

    [[nodiscard]] std::vector<float> ground_heights(std::int32_t bx, std::int32_t bz) override { return m_maker.ground_heights({bx, bz}); }

    [[nodiscard]] std::vector<Tree> trees(std::int32_t bx, std::int32_t bz) override { return m_maker.trees({bx, bz}); }

    [[nodiscard]] std::shared_ptr<const Box> box(const BoxKey& key) override {
        check(key.level);
        if (!touches_land(key.level, key.bx, key.bz)) return nullptr;
        if (key.level > 0) return coarse_box(key);
        if (!voxel::boxes_over(m_info.bounds, 0).contains(key)) return nullptr;
        const auto column = m_columns.get(
            BoxKey{0, key.bx, 0, key.bz}, [&] { return std::make_shared<BoxColumn>(m_maker.make({key.bx, key.bz})); },
            [](const auto& c) { return c->memory_bytes(); });
        const std::int64_t index = std::int64_t{key.by} - column->by_begin;
        return index >= 0 && index < static_cast<std::int64_t>(column->boxes.size()) ? column->boxes[static_cast<std::size_t>(index)] : nullptr;
    }

    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        check(level);
        if (!touches_land(level, bx, bz)) return {};
        const auto range = voxel::boxes_over(m_info.bounds, level);
        if (bx < range.min.bx || bx >= range.max.bx || bz < range.min.bz || bz >= range.max.bz) return {};
        return {range.min.by, range.max.by};
    }

private:
    void check(int level) const {
        if (level < 0 || level >= m_info.levels) throw UsageError("make a box: level " + std::to_string(level) + "; allowed: 0 to " + std::to_string(m_info.levels - 1));
    }

    // Between files far apart is nothing: without this, a coarse box would be looked for down to each of its columns.
    [[nodiscard]] bool touches_land(int level, std::int32_t bx, std::int32_t bz) const noexcept {
        const std::int64_t edge_x = std::int64_t{voxel::kBoxSizeX} << level, edge_z = std::int64_t{voxel::kBoxSizeZ} << level;
        const std::int64_t x = bx * edge_x, z = bz * edge_z;
        return std::any_of(m_islands.begin(), m_islands.end(), [&](const ColumnRect& r) {
            return x < r.max_x && r.min_x < x + edge_x && z < r.max_z && r.min_z < z + edge_z;
        });
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
    const Settings m_settings;
    PointSet m_points;
    const std::unique_ptr<imagery::Orthophotos> m_images;
    BoxColumnMaker m_maker;
    voxel::WorldInfo m_info;
    std::vector<ColumnRect> m_islands;  ///< of all files: elsewhere is nothing
    util::Cache<BoxKey, BoxColumn, voxel::BoxKeyHash> m_columns;
    util::Cache<BoxKey, Box, voxel::BoxKeyHash> m_coarse;
};

}  // namespace

std::unique_ptr<LidarWorld> open_lidar_world(const LidarWorldOptions& options, util::StageTimes& times) {
    return std::make_unique<LidarWorldImpl>(options, times);
}

}  // namespace terravox::voxelize
