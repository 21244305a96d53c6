#include "voxelserver/voxelize/water_fill.hpp"

#include <array>
#include <cmath>
#include <cstdint>

#include "common/voxel/world.hpp"
#include "voxelserver/water/deepening.hpp"

namespace terravox::voxelize {
namespace {

class WaterFiller {
public:
    WaterFiller(const Window& window, WaterAccess* water) : m_window(window), m_water(water) {}

    /// @return NaN when the column is no water
    [[nodiscard]] float level(int x, int z) {
        const Column& column = m_window.column(x, z);
        if (column.roof.seen() && column.roof_points >= column.water_points) return kNoHeight;
        if (m_water == nullptr) return column.water.height;
        const std::int32_t cell = m_water->cell_voxels;
        if (!column.water.seen() && !has_bodies(x, z)) return kNoHeight;  // most of the land ends here
        const std::int32_t cx = voxel::floor_div(m_window.middle.x0() + x, cell), cz = voxel::floor_div(m_window.middle.z0() + z, cell);
        if (column.water.seen()) {
            const float near = m_water->bodies.level_near(cx, cz);
            return std::isnan(near) ? like_a_body_around(cx, cz, column.water.height) : near;
        }
        // Only places without ground, or with ground that looks wet, can be a body's.
        if (column.ground.seen() && !cells(x, z).at((x & 63) / cell, (z & 63) / cell).looks_wet) return kNoHeight;
        return levels_at(x, z, cell);
    }

private:
    // Returns between a lake and reeds or an island's shore: the lake's, when it lies within some cells and stands as high.
    [[nodiscard]] float like_a_body_around(std::int32_t cx, std::int32_t cz, float own) const {
        constexpr std::int32_t kFar = 4;
        constexpr float kSame = 1;  // voxels: rounding alone may part them by one
        for (std::int32_t r = 2; r <= kFar; ++r)
            for (std::int32_t dz = -r; dz <= r; ++dz)
                for (std::int32_t dx = -r; dx <= r; dx += dz == -r || dz == r ? 1 : 2 * r) {
                    const float level = m_water->bodies.level(cx + dx, cz + dz);
                    if (std::abs(level - own) < kSame) return level;
                }
        return own;
    }

    struct Known {
        std::shared_ptr<const water::CellPatch> cells;
        std::shared_ptr<const water::PatchLevels> levels;
        bool asked = false;
    };
    [[nodiscard]] Known& known(int x, int z) { return m_known[static_cast<std::size_t>(((z >> 6) + 1) * 3 + (x >> 6) + 1)]; }

    [[nodiscard]] const water::CellPatch& cells(int x, int z) {
        Known& k = known(x, z);
        if (!k.cells) k.cells = m_water->cells.cells(m_window.middle.px + (x >> 6), m_window.middle.pz + (z >> 6));
        return *k.cells;
    }

    [[nodiscard]] bool has_bodies(int x, int z) {
        Known& k = known(x, z);
        if (!k.asked) k.levels = m_water->bodies.levels(m_window.middle.px + (x >> 6), m_window.middle.pz + (z >> 6)), k.asked = true;
        return k.levels != nullptr;
    }

    [[nodiscard]] float levels_at(int x, int z, int cell) { return has_bodies(x, z) ? known(x, z).levels->at((x & 63) / cell, (z & 63) / cell) : kNoHeight; }

    const Window& m_window;
    WaterAccess* m_water;
    std::array<Known, 9> m_known;
};

void deepen(WaterColumns& out, WaterFiller& filler, const Settings& settings, double voxel_m) {
    using Mask = Grid<std::uint8_t, Margined<float>::kMargin + kShoreReach>;
    Mask mask;
    Mask::each([&](int x, int z) {
        const bool known = x >= -WaterColumns::kMargin && x < kPatchSize + WaterColumns::kMargin && z >= -WaterColumns::kMargin && z < kPatchSize + WaterColumns::kMargin;
        mask.at(x, z) = known ? out.is_water(x, z) : !std::isnan(filler.level(x, z));
    });
    const water::Deepening shape{settings.water.slope, settings.water.min_depth_m, settings.water.max_depth_m, kShoreReach};
    const std::vector<float> depths = water::depths_m(mask.values(), Mask::kSide, Mask::kSide, voxel_m, shape);
    constexpr int kSkip = Mask::kMargin;
    Margined<float>::each([&](int x, int z) { out.depth_m.at(x, z) = depths[static_cast<std::size_t>((z + kSkip) * Mask::kSide + x + kSkip)]; });
}

}  // namespace

WaterColumns fill_water(const Window& window, WaterAccess* water, const Settings& settings, double voxel_m) {
    WaterColumns out;
    WaterFiller filler(window, water);
    bool any = false;
    Grid<float, WaterColumns::kMargin>::each([&](int x, int z) {
        out.level.at(x, z) = filler.level(x, z);
        any = any || out.is_water(x, z);
    });
    if (!any) return out;
    if (settings.steps.water_deepening) deepen(out, filler, settings, voxel_m);
    else Margined<float>::each([&](int x, int z) { out.depth_m.at(x, z) = static_cast<float>(settings.water.min_depth_m); });
    return out;
}

}  // namespace terravox::voxelize
