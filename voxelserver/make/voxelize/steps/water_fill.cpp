#include "voxelserver/make/voxelize/steps/water_fill.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "common/voxel/world.hpp"
#include "voxelserver/data/water/deepening.hpp"

namespace terravox::voxelize {
namespace {

class WaterFiller {
public:
    WaterFiller(const Window& window, WaterAccess* water) : m_window(window), m_water(water) {}

    /// @return NaN when the column is not water
    [[nodiscard]] float level(int x, int z) {
        const Column& column = m_window.column(x, z);
        if (column.roof.seen() && column.roof_points >= column.water_points)
            return kNoHeight;
        if (m_water == nullptr)
            return column.water.height;
        const std::int32_t cell = m_water->cell_voxels;
        const std::int32_t cx = voxel::floor_div(m_window.middle.x0() + x, cell);
        const std::int32_t cz = voxel::floor_div(m_window.middle.z0() + z, cell);
        if (column.water.seen()) {
            const float near = m_water->level_near(cx, cz);
            return std::isnan(near) ? like_a_body_around(cx, cz, column.water.height) : near;
        }
        const water::WaterCell& own = cells(x, z).at((x & 63) / cell, (z & 63) / cell);
        // Only places without ground, or with ground that looks wet, can belong to a body.
        if (!m_water->bodies.may_be_water(own) || (column.ground.seen() && !own.looks_wet))
            return kNoHeight;
        return find_level(cx, cz);
    }

private:
    // Returns between a lake and reeds or an island's shore belong to the lake when it lies within
    // some cells at the same height.
    [[nodiscard]] float like_a_body_around(std::int32_t cx, std::int32_t cz, float own) const {
        constexpr std::int32_t kFar = 4;
        constexpr float kSame = 1;  // voxels: rounding alone may cause a difference of one
        for (std::int32_t r = 2; r <= kFar; ++r)
            for (std::int32_t dz = -r; dz <= r; ++dz)
                for (std::int32_t dx = -r; dx <= r; dx += dz == -r || dz == r ? 1 : 2 * r) {
                    const float level = m_water->level(cx + dx, cz + dz);
                    if (std::abs(level - own) < kSame)
                        return level;
                }
        return own;
    }

    [[nodiscard]] const water::CellPatch& cells(int x, int z) {
        auto& known = m_cells[static_cast<std::size_t>(((z >> 6) + 1) * 3 + (x >> 6) + 1)];
        if (!known)
            known =
                m_water->cells.cells(m_window.middle.px + (x >> 6), m_window.middle.pz + (z >> 6));
        return *known;
    }

    // Columns of a cell follow each other.
    [[nodiscard]] float find_level(std::int32_t cx, std::int32_t cz) {
        if (cx != m_last_x || cz != m_last_z) {
            m_last_x = cx;
            m_last_z = cz;
            m_last_level = m_water->level(cx, cz);
        }
        return m_last_level;
    }

    const Window& m_window;
    WaterAccess* m_water;
    std::array<std::shared_ptr<const water::CellPatch>, 9> m_cells;
    // Initially a cell that does not exist.
    std::int32_t m_last_x = std::numeric_limits<std::int32_t>::min();
    std::int32_t m_last_z = 0;
    float m_last_level = kNoHeight;
};

}  // namespace

WaterColumns fill_water(const Window& window, WaterAccess* water) {
    WaterColumns out;
    WaterFiller filler(window, water);
    Grid<float, WaterColumns::kMargin>::each([&](int x, int z) {
        out.level.at(x, z) = filler.level(x, z);
        out.any = out.any || out.is_water(x, z);
    });
    return out;
}

void deepen_water(const Window& window, WaterAccess* water, const Settings::Water& settings,
                  double voxel_m, WaterColumns& columns) {
    if (!columns.any)
        return;
    WaterFiller filler(window, water);
    using Mask = Grid<std::uint8_t, Margined<float>::kMargin + kShoreReach>;
    Mask mask;
    Mask::each([&](int x, int z) {
        const bool known =
            x >= -WaterColumns::kMargin && x < grid::kPatchSize + WaterColumns::kMargin &&
            z >= -WaterColumns::kMargin && z < grid::kPatchSize + WaterColumns::kMargin;
        mask.at(x, z) = known ? columns.is_water(x, z) : !std::isnan(filler.level(x, z));
    });
    const water::Deepening shape{settings.slope, settings.min_depth_m, settings.max_depth_m,
                                 kShoreReach};
    const std::vector<float> depths =
        water::depths_m(mask.values(), Mask::kSide, Mask::kSide, voxel_m, shape);
    constexpr int kSkip = Mask::kMargin;
    Margined<float>::each([&](int x, int z) {
        columns.depth_m.at(x, z) =
            depths[static_cast<std::size_t>((z + kSkip) * Mask::kSide + x + kSkip)];
    });
}

void level_bed(double depth_m, WaterColumns& columns) {
    if (columns.any)
        columns.depth_m = Margined<float>(static_cast<float>(depth_m));
}

}  // namespace terravox::voxelize
