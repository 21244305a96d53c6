#pragma once

#include "common/voxel/world.hpp"
#include "raytracer/core/output/picture.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::analyse {

/// The cells of a raster: squares whose borders are whole multiples of their edge, in the world's
/// CRS or, without one, in its voxels. Rasters of the same edge therefore have cells in common.
struct CellGrid {
    std::int64_t west = 0;   ///< of the first column, in cells
    std::int64_t north = 0;  ///< z of the first row, in cells: to the south, as in the world
    int columns = 0;
    int rows = 0;
    double edge_voxels = 1;  ///< of level 0
    double edge_m = 1;

    static constexpr int kMaxSide = 65536;
};

/// The grid whose cells cover an area.
/// @param area level-0 voxels, not empty
/// @param edge_m nullopt: that of a voxel
/// @param least_voxels smallest edge that is allowed, in voxels
/// @throws UsageError for smaller cells, or more than CellGrid::kMaxSide of them
[[nodiscard]] CellGrid grid_over(const voxel::WorldInfo& world, const voxel::VoxelBounds& area,
                                 std::optional<double> edge_m, double least_voxels = 1);

/// Turns a scene's camera to a grid: an orthographic one looks straight down, and each of its
/// pixels is a cell.
void set_camera(const CellGrid& grid, const voxel::WorldInfo& world, scene::Scene& scene);

/// Makes a scene that of an analysis: its picture is the grid's, with one ray through the middle of
/// each cell. In worlds wider than 20 km the sun is that of the middle of a square of 10 km
/// (analysis.place).
/// @throws Error where that is outside of the domain of the world's CRS
void look_at_cells(const CellGrid& grid, const voxel::WorldInfo& world, scene::Scene& scene);

/// The grid that a scene looks at: the inverse of look_at_cells().
/// @throws Error for a scene that look_at_cells() has not made
[[nodiscard]] CellGrid make_grid(const scene::Scene& scene, const voxel::WorldInfo& world);

/// Where the raster lies: in the world's CRS, or without one in metres, with y to the north.
[[nodiscard]] output::GeoPlacement make_placement(const CellGrid& grid,
                                                  const voxel::WorldInfo& world);

}  // namespace terravox::analyse
