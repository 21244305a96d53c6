#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "raytracer/apps/commands/analyse/object_arguments.hpp"
#include "raytracer/apps/commands/analyse/raster_outputs.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/checkpoint/tile_journal.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// What `merge` makes of an analysis in addition to its raster, as `analyse` does.
struct JoinedRasterArguments {
    ReportArguments reports;
    ObjectArguments objects;
    bool as_json = false;
};

void add_joined_raster_options(CLI::App& command, JoinedRasterArguments& args);

/// Refuses options that only rasters have.
/// @throws UsageError
void check_is_no_raster(const JoinedRasterArguments& args);

/// Checks, before anything is written, that the raster can be.
/// @param scene of the checkpoint, with an analysis
/// @throws UsageError, Error
void check_joined_raster(const scene::Scene& scene, const std::vector<std::string>& outputs,
                         const JoinedRasterArguments& args);

/// Writes the files that `analyse` would have written without --part: the same bytes.
/// @param tiles must be complete
/// @param threads for compression, at least 1
/// @return kHoles where boxes could not be read
/// @throws Error, UsageError
[[nodiscard]] util::ExitCode write_joined_raster(const farm::JoinedTiles& tiles,
                                                 const scene::Scene& scene,
                                                 const std::string& output,
                                                 const JoinedRasterArguments& args, int threads,
                                                 bool quiet);

/// Adds `merge` to the program's commands.
/// @return runs the command once the arguments are parsed
/// @throws (when run) Error, UsageError
[[nodiscard]] std::function<util::ExitCode()> add_merge_command(CLI::App& app);

}  // namespace terravox::commands
