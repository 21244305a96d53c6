#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/voxel/world.hpp"
#include "raytracer/analyse/objects/objects.hpp"
#include "raytracer/analyse/raster/cell_grid.hpp"
#include "raytracer/core/scene/scene.hpp"

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

/// The description names the days and the source.
[[nodiscard]] analyse::ObjectFileInfo object_file_info(const scene::Scene& scene,
                                                       const analyse::CellGrid& grid,
                                                       const voxel::WorldInfo& world);

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

}  // namespace terravox::commands
