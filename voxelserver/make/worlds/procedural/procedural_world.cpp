#include "voxelserver/make/worlds/procedural/procedural_world.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>

#include "common/util/cache.hpp"
#include "common/util/error.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "voxelserver/make/worlds/procedural/columns.hpp"

namespace terravox::procedural {
namespace {

using voxel::Box;
using voxel::BoxKey;

constexpr std::int32_t kHalfWidth = std::int32_t{1} << 24;
constexpr std::int32_t kHalfFrame = 256;

class ProceduralWorld final : public voxel::World {
public:
    explicit ProceduralWorld(const Settings& settings) : m_maker(settings) { describe(); }

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }

    [[nodiscard]] std::shared_ptr<const Box> box(const BoxKey& key) override {
        voxel::check_level(m_info, key.level);
        if (m_stopped)
            throw util::Error("make box {}: interrupted", to_string(key));
        if (!boxes_over(m_info.bounds, key.level).contains(key))
            return nullptr;
        const auto columns = m_columns.get(
            {key.level, key.bx, 0, key.bz},
            [&] {
                return std::make_shared<const Columns>(m_maker.make(key.level, key.bx, key.bz));
            },
            [](const auto& made) { return made->memory_bytes(); });
        return make_box(key, *columns);
    }

    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        voxel::check_level(m_info, level);
        return voxel::column_of_bounds(m_info.bounds, level, bx, bz);
    }

    void stop() noexcept override { m_stopped = true; }

private:
    void describe() {
        const Terrain& terrain = m_maker.terrain();
        const Settings& s = terrain.settings();
        // The floor is that of a box: rock has no face there, and none is stored. It is below 0, so
        // that at the coarsest level there is a voxel of ground.
        const auto deepest =
            std::min(static_cast<std::int32_t>(std::floor(terrain.lowest())), 0) - 1;
        const std::int32_t low = voxel::floor_div(deepest, voxel::kBoxSizeY) * voxel::kBoxSizeY;
        const auto high = static_cast<std::int32_t>(
            std::ceil(std::max(terrain.highest(), Vegetation::highest_ground(s) + kTreeHeight)));
        m_info.title = "generated " + std::to_string(s.seed);
        m_info.bounds = {{-kHalfWidth, low, -kHalfWidth}, {kHalfWidth, high, kHalfWidth}};
        m_info.voxel_m = m_info.crs_units_per_voxel = s.voxel_m;
        m_info.levels = voxel::levels_for(m_info.bounds);
        const auto seen =
            static_cast<std::int32_t>(std::ceil(terrain.highest_about_origin(kHalfFrame)));
        m_info.framed = {{-kHalfFrame, s.water_level - 8, -kHalfFrame},
                         {kHalfFrame, std::max(seen, s.water_level + 24), kHalfFrame}};
    }

    [[nodiscard]] static std::shared_ptr<const Box> make_box(const BoxKey& key,
                                                             const Columns& columns) {
        const std::int32_t y0 = key.by * voxel::kBoxSizeY;
        if (columns.highest() <= y0)
            return nullptr;
        voxel::BoxBuilder builder;
        for (int z = -1; z <= voxel::kBoxSizeZ; ++z)
            for (int x = -1; x <= voxel::kBoxSizeX; ++x) {
                const Column& c = columns.at(x, z);
                builder.add(x, z, -1, c.top - (c.wooded ? 1 : 0) - y0, true);
                if (c.wooded)
                    builder.add(x, z, c.top - 1 - y0, c.top - y0, false);
                if (c.water > c.top)
                    builder.add(x, z, c.top - y0, c.water - (c.snow ? 1 : 0) - y0, false);
                if (c.snow)
                    builder.add(x, z, c.water - 1 - y0, c.water - y0, true);
                for (std::int32_t i = c.first_run; i >= 0;
                     i = columns.runs()[static_cast<std::size_t>(i)].next) {
                    const Columns::Run& run = columns.runs()[static_cast<std::size_t>(i)];
                    builder.add(x, z, run.y0 - y0, run.y1 - y0, !see_through(run.attr.material));
                }
            }
        return builder.build(key, [&](int x, int y, int z) { return columns.attr(x, y0 + y, z); });
    }

    static constexpr std::size_t kColumnBytes = std::size_t{8} << 20;
    ColumnMaker m_maker;
    voxel::WorldInfo m_info;
    util::Cache<BoxKey, Columns, voxel::BoxKeyHash> m_columns{kColumnBytes};  ///< by = 0
    std::atomic<bool> m_stopped{false};
};

}  // namespace

std::unique_ptr<voxel::World> open_procedural_world(const Settings& settings) {
    return std::make_unique<ProceduralWorld>(settings);
}

}  // namespace terravox::procedural
