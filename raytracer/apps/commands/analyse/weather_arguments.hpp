#pragma once

#include <optional>
#include <string>

#include "common/voxel/world.hpp"
#include "raytracer/analyse/solar/weather_file.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// @param file to be set: an EPW file, or empty
void add_weather_option(CLI::App& command, std::string& file);

/// Reads the weather file of a command line.
/// @param world with the fields that were given on the command line
/// @return nullopt where none is given
/// @throws UsageError together with a turbidity; Error as solar::read_weather()
[[nodiscard]] std::optional<solar::WeatherFile> read_weather(const std::string& file,
                                                             const WorldArguments& world);

}  // namespace terravox::commands
