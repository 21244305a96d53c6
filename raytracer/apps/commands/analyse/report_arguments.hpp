#pragma once

#include <stop_token>
#include <string>
#include <vector>

#include "common/voxel/world.hpp"
#include "raytracer/analyse/raster/cell_file.hpp"
#include "raytracer/analyse/raster/cell_grid.hpp"
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
    /// Paths of the scene's fields that the analysis has options for.
    std::vector<std::string> fields;
    std::vector<std::string> additions;  ///< planned objects, as they were given
    std::string weather;                 ///< file instead of a clear sky; empty: none
    std::size_t missing_boxes = 0;
};

/// @throws Error "interrupted" when stopped; Error when they cannot be written
void write_reports(const ReportArguments& args, analyse::CellFile& cells, const Reported& what,
                   const std::stop_token& stop);

}  // namespace terravox::commands
