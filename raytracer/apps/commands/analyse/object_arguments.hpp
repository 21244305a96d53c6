#pragma once

#include <stop_token>
#include <string>
#include <vector>

#include "common/voxel/world.hpp"
#include "raytracer/analyse/objects/objects.hpp"
#include "raytracer/analyse/objects/polygon_cells.hpp"
#include "raytracer/analyse/raster/cell_file.hpp"
#include "raytracer/analyse/raster/cell_grid.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/render/picture_renderer.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Objects that are written in addition to the raster.
struct ObjectArguments {
    std::string file;      ///< .gpkg; empty: none
    std::string polygons;  ///< GeoJSON; empty: the buildings of the raster
};

void add_object_options(CLI::App& command, ObjectArguments& args);

/// Rejects what cannot be before any work is done.
/// @param has_facades whether facades are written
/// @throws UsageError, Error
void check_object_arguments(const ObjectArguments& args, const scene::Scene& scene,
                            bool has_facades);

/// Objects that will be written when the raster is finished; none without a file, but polygons.
class PlannedObjects {
public:
    /// @param world must outlive it
    /// @throws Error as analyse::read_polygons()
    PlannedObjects(const ObjectArguments& args, const scene::Scene& scene,
                   const analyse::CellGrid& grid, const voxel::WorldInfo& world);

    /// Empty: the buildings of the raster.
    [[nodiscard]] const std::vector<analyse::ObjectPolygon>& polygons() const noexcept {
        return m_polygons;
    }
    /// @throws Error; "interrupted" when stopped
    void write(analyse::CellFile& cells, const std::stop_token& stop) const;

private:
    const std::string m_file;
    analyse::ObjectFileInfo m_info;
    std::vector<analyse::ObjectPolygon> m_polygons;
    const double m_cell_m2;
};

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
