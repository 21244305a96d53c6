#include "raytracer/analyse/raster/cell_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "raytracer/analyse/evaluators/analysis.hpp"

namespace terravox::analyse {
namespace {

std::string metres(double v) {
    return util::number_text(v, 6);
}

/// Whole cells that cover [from, to) voxels.
struct CellRange {
    std::int64_t begin = 0;
    std::int64_t count = 0;
};
CellRange cells_over(std::int32_t from, std::int32_t to, double edge) {
    const double begin = std::floor(from / edge);
    return {static_cast<std::int64_t>(begin),
            static_cast<std::int64_t>(std::ceil(to / edge) - begin)};
}

/// Where the sun of a raster is looked up: in the middle of the square of the map that holds the
/// raster's middle, so that rasters within one square have the same sun.
/// @param x, z the raster's middle, level-0 voxels
/// @return nullopt: in the middle of the world, which is near enough everywhere, or has no place
std::optional<std::array<double, 3>> place_of_sun(const voxel::WorldInfo& world, double x,
                                                  double z) {
    constexpr double kSquare_m = 10'000;
    const double square = kSquare_m / world.voxel_m;
    const voxel::VoxelBounds& bounds = world.bounds;
    const double width = std::max(static_cast<double>(bounds.max[0]) - bounds.min[0],
                                  static_cast<double>(bounds.max[2]) - bounds.min[2]);
    if (!world.centre || world.crs_wkt.empty() || width <= 2 * square)
        return std::nullopt;
    const auto middle = [&](double at) { return (std::floor(at / square) + 0.5) * square; };
    const double units = world.crs_units_per_voxel;
    const geo::MapPlace place =
        geo::map_place(geo::Crs::from_wkt(world.crs_wkt), middle(x) * units, -middle(z) * units);
    return std::array{place.lat_deg, place.lon_deg, place.convergence_deg};
}

}  // namespace

CellGrid grid_over(const voxel::WorldInfo& world, const voxel::VoxelBounds& area,
                   std::optional<double> edge_m, double least_voxels) {
    constexpr double kMax_m = 100'000;
    const double edge = edge_m.value_or(world.voxel_m);
    const double least_m = world.voxel_m * least_voxels;
    if (!(edge >= least_m && edge <= kMax_m))
        throw util::UsageError("lay out the raster: --resolution " + metres(edge) +
                               " m; allowed: " + metres(least_m) + " to " + metres(kMax_m) +
                               " (a voxel of this world: " + metres(world.voxel_m) + ")");
    CellGrid out;
    out.edge_m = edge;
    out.edge_voxels = edge / world.voxel_m;
    const CellRange columns = cells_over(area.min[0], area.max[0], out.edge_voxels);
    const CellRange rows = cells_over(area.min[2], area.max[2], out.edge_voxels);
    if (columns.count > CellGrid::kMaxSide || rows.count > CellGrid::kMaxSide)
        throw util::UsageError("lay out the raster: " + std::to_string(columns.count) + " x " +
                               std::to_string(rows.count) + " cells of " + metres(edge) +
                               " m; allowed: up to " + std::to_string(CellGrid::kMaxSide) +
                               " a side, by --area or a coarser --resolution");
    out.west = columns.begin;
    out.north = rows.begin;
    out.columns = static_cast<int>(columns.count);
    out.rows = static_cast<int>(rows.count);
    return out;
}

void set_camera(const CellGrid& grid, const voxel::WorldInfo& world, scene::Scene& scene) {
    const double x = (static_cast<double>(grid.west) + grid.columns / 2.0) * grid.edge_voxels;
    const double z = (static_cast<double>(grid.north) + grid.rows / 2.0) * grid.edge_voxels;
    const double y = world.bounds.max[1];
    scene.camera = {};
    scene.camera.projection = core::CameraProjection::kOrthographic;
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.camera.target = {x, y, z};
    scene.camera.position = {x, y + 1, z};
    scene.camera.height_m = grid.rows * grid.edge_m;
    scene.camera.inside_rock = true;
    scene.output.size_px = {grid.columns, grid.rows};
}

void look_at_cells(const CellGrid& grid, const voxel::WorldInfo& world, scene::Scene& scene) {
    scene.output = {};
    set_camera(grid, world, scene);
    const auto& target = *scene.camera.target;
    scene.analysis.cell_m = grid.edge_m;
    const bool sees_sun = find_analysis(scene.analysis.kind).sun != SunUse::kNone;
    scene.analysis.place = sees_sun ? place_of_sun(world, target[0], target[2]) : std::nullopt;
    scene.quality.samples = 1;
    scene.quality.noise = 0;
    scene.quality.time_s = 0;
    scene.quality.coarse_step = 1;
}

CellGrid make_grid(const scene::Scene& scene, const voxel::WorldInfo& world) {
    CellGrid out;
    out.edge_m = scene.analysis.cell_m;
    out.edge_voxels = out.edge_m / world.voxel_m;
    out.columns = scene.output.size_px[0];
    out.rows = scene.output.size_px[1];
    const auto& target = scene.camera.target;
    // Whole numbers far below this one are exact.
    constexpr double kFar = 1e12;
    const double west = target ? (*target)[0] / out.edge_voxels - out.columns / 2.0 : kFar;
    const double north = target ? (*target)[2] / out.edge_voxels - out.rows / 2.0 : kFar;
    if (!(out.edge_m > 0) || !(std::abs(west) < kFar) || !(std::abs(north) < kFar))
        throw util::Error("find the cells of a raster: cells of " + metres(out.edge_m) +
                          " m, from column " + metres(west) + " and row " + metres(north) +
                          " on; allowed: the scene of an analysis");
    out.west = std::llround(west);
    out.north = std::llround(north);
    return out;
}

output::GeoPlacement make_placement(const CellGrid& grid, const voxel::WorldInfo& world) {
    const double unit = world.crs.empty() ? world.voxel_m : world.crs_units_per_voxel;
    const double edge = grid.edge_voxels * unit;
    return {{static_cast<double>(grid.west) * edge, edge, 0,
             -static_cast<double>(grid.north) * edge, 0, -edge},
            world.crs_wkt};
}

}  // namespace terravox::analyse
