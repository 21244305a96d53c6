#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/analyse/evaluators/sight.hpp"
#include "raytracer/analyse/raster/cell_grid.hpp"
#include "raytracer/apps/commands/analyse/object_arguments.hpp"
#include "raytracer/apps/commands/analyse/raster_outputs.hpp"
#include "raytracer/apps/commands/analyse/sun_arguments.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/apps/commands/run_arguments.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/render/loaded_world.hpp"
#include "raytracer/farm/render/picture_renderer.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// The forms of an observer, for help and messages.
inline constexpr const char* kObserverForms =
    "E,N,H (height H), E,N,+H (H above the roof, crown or ground there), or E,N,H,above-ground, "
    "metres; E and N in the world's CRS, x and z in voxels where it has none";

/// The forms of a file of observers, for help.
inline constexpr const char* kObserverFileForm =
    "GeoJSON file of points and lines that look: at their third coordinate, at 'height' metres "
    "above the ground where a feature has that property, else at 1.6";

/// The observers of a command line.
struct ObserverArguments {
    std::vector<std::string> texts;  ///< each one of kObserverForms
    std::vector<std::string> files;
    double step_m = 10;  ///< between the observers of a line
};

/// Reads an observer.
/// @param text one of kObserverForms
/// @throws UsageError for any other text
[[nodiscard]] analyse::Observer parse_observer(const std::string& text,
                                               const voxel::WorldInfo& world);

/// @throws UsageError also for none, and for more than a scene holds; Error for a file that cannot
/// be read
[[nodiscard]] std::vector<analyse::Observer> parse_observers(const ObserverArguments& args,
                                                             const voxel::WorldInfo& world);

/// Arguments of all analyses, and those of terrain and sight.
struct AnalyseArguments {
    WorldArguments world;
    RenderPoolArguments render_pool;
    std::string output;
    GridArguments grid;
    std::optional<int> level;
    ObserverArguments observers;
    ObjectArguments objects;
    ReportArguments reports;
    bool as_json = false;
    SunArguments sun;
    std::string weather;
    HorizonArguments horizon;
    FacadeArguments facades;
    std::string part;
    bool resume = false;
    Verbosity verbosity;
};

/// Measures a world and writes what the arguments ask for: a raster, or a part of its tiles, and
/// the files made of it.
/// @return kHoles where values are missing because boxes were not available
/// @throws UsageError for arguments that cannot be, before any work is done; Error, also
/// "interrupted" when stopped by a signal
[[nodiscard]] util::ExitCode run_analyse(const AnalyseArguments& args, core::AnalysisKind kind);

/// Adds `analyse` to the program's commands.
/// @return runs the command once the arguments are parsed
/// @throws (when run) Error, UsageError
[[nodiscard]] std::function<util::ExitCode()> add_analyse_command(CLI::App& app);

}  // namespace terravox::commands
