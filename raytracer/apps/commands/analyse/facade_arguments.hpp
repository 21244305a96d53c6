#pragma once

#include <stop_token>
#include <string>
#include <vector>

#include "common/voxel/world.hpp"
#include "raytracer/analyse/objects/polygon_cells.hpp"
#include "raytracer/analyse/raster/cell_file.hpp"
#include "raytracer/analyse/raster/cell_grid.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/render/picture_renderer.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Facades that are written in addition to a raster of energy.
struct FacadeArguments {
    std::string file;  ///< .gpkg; empty: none
};

void add_facade_options(CLI::App& command, FacadeArguments& args);

/// Rejects what cannot be before any work is done.
/// @param is_part only a part of the raster is made
/// @throws UsageError, Error
void check_facade_arguments(const FacadeArguments& args, const scene::Scene& scene, bool is_part);

/// What facades are measured with.
struct FacadeRun {
    const scene::Scene& scene;  ///< of the raster of energy
    const analyse::CellGrid& grid;
    const voxel::WorldInfo& world;
    render::PictureRenderer& renderer;
    const std::stop_token& stop;
    /// Whose facades are wanted; empty: the buildings of the raster.
    const std::vector<analyse::ObjectPolygon>& polygons;
};

/// Measures the walls of buildings, side by side and storey by storey, and writes them.
/// @param energy the finished raster
/// @param[in,out] statistics those of the raster; what this costs and misses is added
/// @throws Error; "interrupted" when stopped
void make_facades(const FacadeArguments& args, const FacadeRun& run, analyse::CellFile& energy,
                  render::RenderStatistics& statistics);

}  // namespace terravox::commands
