#include "raytracer/apps/commands/analyse/object_arguments.hpp"

#include <CLI/CLI.hpp>
#include <optional>

#include "common/geo/gdal_files.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "raytracer/analyse/objects/cell_labels.hpp"
#include "raytracer/analyse/objects/facades.hpp"

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

namespace {

/// The description names the days and the source.
analyse::ObjectFileInfo object_file_info(const scene::Scene& scene, const analyse::CellGrid& grid,
                                         const voxel::WorldInfo& world) {
    const scene::Scene::Analysis& analysis = scene.analysis;
    const std::string days =
        analysis.from.empty() ? scene.sun.date : analysis.from + " to " + analysis.to;
    return {analyse::make_placement(grid, world),
            "Energy of sun and sky, kWh, of " + days + ". " + world.attribution};
}

}  // namespace

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

namespace {

/// No wall has more: with the smallest storeys it is a kilometre high.
constexpr int kMaxStoreys = 1000;

/// Which cell belongs to which building.
analyse::LabelFile list_numbers(const FacadeArguments& args, const FacadeRun& run,
                                analyse::CellFile& energy) {
    if (!run.polygons.empty())
        return {args.file,
                run.polygons,
                run.grid.columns,
                run.grid.rows,
                run.grid.edge_voxels < 2 ? analyse::LabelFile::kMaxNear : 1,
                run.stop};
    analyse::ConnectedCells found(energy, run.grid.edge_m * run.grid.edge_m, run.stop);
    return {args.file, found, run.grid.columns, run.grid.rows};
}

/// Measures the walls of a side and a storey.
/// @return whether there is any
bool measure(const FacadeArguments& args, const FacadeRun& run, GDALDatasetH buildings,
             const scene::Scene& scene, analyse::FacadeSums& sums,
             render::RenderStatistics& statistics) {
    std::optional<analyse::CellFile> cells;
    bool has_walls = false;
    const auto begin = [&]() -> output::TileSink& {
        cells.emplace(args.file, scene.analysis.kind, run.grid.columns, run.grid.rows,
                      scene.quality.tile.in_picture(run.grid.columns));
        return *cells;
    };
    const auto write = [&](const render::RenderStatistics&) {
        has_walls =
            sums.add(*cells, buildings, scene.analysis.side, scene.analysis.storey, run.stop);
    };
    render::RenderStatistics now =
        run.renderer.render_tiles(scene, args.file, begin, write, {false, true, {}});
    now.counts.add(statistics.counts);
    now.seconds += statistics.seconds;
    statistics = now;
    return has_walls;
}

}  // namespace

void add_facade_options(CLI::App& command, FacadeArguments& args) {
    command.add_option("--facades", args.file,
                       "GeoPackage to write, too: energy, hours of sun and the view of the sky of "
                       "each storey of each wall of the buildings");
}

void check_facade_arguments(const FacadeArguments& args, const scene::Scene& scene, bool is_part) {
    if (args.file.empty())
        return;
    if (is_part)
        throw util::UsageError(
            "analyse energy: --facades together with --part; allowed: one of them");
    if (scene.analysis.surface == core::AnalysisSurface::kGround)
        throw util::UsageError(
            "analyse energy: --facades with --surface ground, where there are no roofs; allowed: "
            "--surface top");
    analyse::check_feature_target(args.file, "facades");
    (void)geo::geopackage_driver();
}

void make_facades(const FacadeArguments& args, const FacadeRun& run, analyse::CellFile& energy,
                  render::RenderStatistics& statistics) {
    const analyse::LabelFile buildings = list_numbers(args, run, energy);
    using Unnumbered = analyse::FacadeSums::Unnumbered;
    analyse::FacadeSums sums(run.polygons.empty() ? Unnumbered::kKept : Unnumbered::kLeftOut);
    scene::Scene scene = run.scene;
    scene.analysis.kind = core::AnalysisKind::kFacade;
    bool has_walls = true;
    for (int storey = 0; has_walls && storey < kMaxStoreys; ++storey) {
        has_walls = false;
        for (const auto& side : core::kWallSides) {
            scene.analysis.storey = storey;
            scene.analysis.side = side.value;
            has_walls |= measure(args, run, buildings.dataset(), scene, sums, statistics);
        }
    }
    const std::size_t count =
        analyse::write_facades(sums, args.file, object_file_info(run.scene, run.grid, run.world));
    if (count == 0)
        util::log_warn("{} has no facades: there is no wall in the raster", args.file);
}

}  // namespace terravox::commands
