#pragma once

#include <optional>
#include <string>

#include "raytracer/apps/commands/analyse/facade_arguments.hpp"
#include "raytracer/apps/commands/analyse/horizon_arguments.hpp"
#include "raytracer/apps/commands/analyse/object_arguments.hpp"
#include "raytracer/apps/commands/analyse/observer_arguments.hpp"
#include "raytracer/apps/commands/analyse/report_arguments.hpp"
#include "raytracer/apps/commands/analyse/sun_arguments.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/apps/commands/grid_arguments.hpp"
#include "raytracer/apps/commands/render_pool_arguments.hpp"
#include "raytracer/apps/commands/run_report.hpp"

namespace terravox::commands {

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

}  // namespace terravox::commands
