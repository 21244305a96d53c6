#pragma once

#include <string>

#include "raytracer/apps/commands/arguments/world_arguments.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Arguments of `analyse sun` that are no fields of a scene.
struct SunArguments {
    std::string at;
    std::string times;  ///< of time_arguments.hpp
    bool monthly = false;
};

void add_sun_options(CLI::App& command, SunArguments& args);

/// @param command the kind's name, for the message
/// @throws UsageError where a day is given as well as a period
void refuse_day_and_period(const std::string& command, const WorldArguments& world,
                           const scene::Scene& scene);

/// Sets the kind that is measured (a day, a period, its months, an instant), and the instant.
/// @param world with the fields that were given on the command line
/// @throws UsageError for options that exclude each other, and for what is no time
void choose_sun_kind(const SunArguments& args, const WorldArguments& world, scene::Scene& scene);

}  // namespace terravox::commands
