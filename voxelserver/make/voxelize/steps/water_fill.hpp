#pragma once

#include "voxelserver/data/water/body_finder.hpp"
#include "voxelserver/make/voxelize/columns/columns.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"

namespace terravox::voxelize {

/// How far from a column its shore is searched for, voxels.
inline constexpr int kShoreReach = 32;

/// Access to bodies of water and their cells, for one patch on one thread; the referenced objects
/// are thread-safe.
struct WaterAccess {
    water::CellSource& cells;
    water::WaterBodies& bodies;
    int cell_voxels = 1;
    /// Extent of all queries made here; cells of the window not counted.
    voxel::InputExtent reach{};

    [[nodiscard]] float level(std::int32_t cx, std::int32_t cz) {
        return bodies.level(cx, cz, &reach);
    }
    [[nodiscard]] float level_near(std::int32_t cx, std::int32_t cz) {
        return bodies.level_near(cx, cz, &reach);
    }
};

/// Water of a patch and the margin that later steps need.
struct WaterColumns {
    static constexpr int kMargin = 8;
    Grid<float, kMargin> level{kNoHeight};  ///< surface, voxels; NaN = no water
    Margined<float> depth_m;                ///< of the bed below the surface
    bool any = false;                       ///< whether fill_water() found any water
    [[nodiscard]] bool is_water(int x, int z) const noexcept {
        return level.at(x, z) == level.at(x, z);
    }
};

/// Step "water equalization": which columns are water, and how high it stands.
///
/// A column is water when it has water returns, or lies in a cell of a water body and nothing solid
/// was seen in it; ground that looks wet in such a cell is water, too.
/// @param water nullptr = levels from the column's own returns (the step is switched off)
/// @return depths are 0 everywhere
[[nodiscard]] WaterColumns fill_water(const Window& window, WaterAccess* water);

/// Step "water deepening": sets depths, which grow from the shore.
/// @param water as it was passed to fill_water()
/// @param columns the result of fill_water() for the same window
void deepen_water(const Window& window, WaterAccess* water, const Settings::Water& settings,
                  double voxel_m, WaterColumns& columns);

/// The same depth for all water, for when the step "water deepening" is switched off.
void level_bed(double depth_m, WaterColumns& columns);

}  // namespace terravox::voxelize
