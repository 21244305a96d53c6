#include "raytracer/apps/commands/analyse/object_arguments.hpp"

#include <CLI/CLI.hpp>

#include "common/geo/writing_drivers.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"

namespace terravox::commands {
void add_object_options(CLI::App& command, ObjectArguments& args) {
    command.add_option("--objects", args.file,
                       "GeoPackage to write, too: area, energy, hours of sun and the best face of "
                       "each building");
    command.add_option("--polygons", args.polygons,
                       "GeoJSON file of polygons that are the objects and have the facades, "
                       "instead of the buildings that are found");
}

void check_object_arguments(const ObjectArguments& args, const scene::Scene& scene,
                            bool has_facades) {
    if (args.file.empty()) {
        if (!args.polygons.empty() && !has_facades)
            throw util::UsageError(
                "analyse energy: --polygons without --objects or --facades; allowed: with them");
        return;
    }
    if (args.polygons.empty() && scene.analysis.surface == core::AnalysisSurface::kGround)
        throw util::UsageError(
            "analyse energy: --objects with --surface ground, where there are no roofs; allowed: "
            "--surface top, or --polygons");
    analyse::check_object_target(args.file);
    (void)geo::geopackage_driver();
}

analyse::ObjectFileInfo object_file_info(const scene::Scene& scene, const analyse::CellGrid& grid,
                                         const voxel::WorldInfo& world) {
    const scene::Scene::Analysis& analysis = scene.analysis;
    const std::string days =
        analysis.from.empty() ? scene.sun.date : analysis.from + " to " + analysis.to;
    return {analyse::placement_of(grid, world),
            "Energy of sun and sky, kWh, of " + days + ". " + world.attribution};
}

PlannedObjects::PlannedObjects(const ObjectArguments& args, const scene::Scene& scene,
                               const analyse::CellGrid& grid, const voxel::WorldInfo& world)
    : m_file(args.file),
      m_info(object_file_info(scene, grid, world)),
      m_cell_m2(grid.edge_m * grid.edge_m) {
    if (!args.polygons.empty())
        m_polygons =
            analyse::read_polygons(args.polygons, m_info.placement, grid.columns, grid.rows);
}

void PlannedObjects::write(analyse::CellFile& cells, const std::stop_token& stop) const {
    if (m_file.empty())
        return;
    if (analyse::write_objects(cells, m_file, m_info, m_polygons, m_cell_m2, stop) == 0)
        util::log_warn("{} has no objects: there is no building in the raster", m_file);
}

}  // namespace terravox::commands
