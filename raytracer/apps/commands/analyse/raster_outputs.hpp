#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/voxel/world.hpp"
#include "raytracer/analyse/raster/cell_file.hpp"
#include "raytracer/analyse/raster/cell_grid.hpp"
#include "raytracer/analyse/raster/relief.hpp"
#include "raytracer/analyse/raster/sight_summary.hpp"
#include "raytracer/apps/commands/analyse/object_arguments.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// What is made for people in addition to the raster; empty: nothing.
struct ReportArguments {
    std::string page;  ///< .html
    std::string map;   ///< .png
};

void add_report_options(CLI::App& command, ReportArguments& args);

/// Rejects what cannot be written before any work is done.
/// @throws UsageError, Error
void check_report_targets(const ReportArguments& args);

/// What a report is about.
struct Reported {
    const voxel::WorldInfo& world;
    const scene::Scene& scene;
    const analyse::CellGrid& grid;
    std::vector<std::string> additions;  ///< planned objects, as they were given
    std::string weather;                 ///< file instead of a clear sky; empty: none
    std::size_t missing_boxes = 0;
};

/// How the slopes of a terrain raster are derived.
/// @throws UsageError for an even window, and for what is no direction of light
[[nodiscard]] analyse::ReliefOptions make_relief(const scene::Scene& scene);

/// What is made of the measured cells of a raster.
struct RasterOutputs {
    const std::string& file;  ///< GeoTIFF
    const ReportArguments& reports;
    const std::optional<PlannedObjects>& objects;
};

/// Derives the bands that depend on neighbours, and writes all files.
/// @param cells with all tiles
/// @param info metadata; the place of the raster is added
/// @param threads for compression
/// @return of an analysis of sight: what is seen
/// @throws Error, also "interrupted" when stopped; UsageError as make_relief()
[[nodiscard]] std::optional<analyse::SightSummary> write_outputs(
    analyse::CellFile& cells, const RasterOutputs& outputs, const Reported& what,
    output::PictureInfo info, int threads, const std::stop_token& stop);

}  // namespace terravox::commands
