#pragma once

#include <optional>
#include <string>

#include "common/voxel/world.hpp"
#include "raytracer/commands/world_arguments.hpp"
#include "raytracer/scene/scene.hpp"
#include "raytracer/solar/weather_file.hpp"

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

/// Puts the light of a weather file into a scene. Warns where the file is of a place far away, and
/// where its light does not fit the sun.
/// @param world with a place
/// @throws UsageError as solar::weather_light() and solar::text_of()
void use_weather(const solar::WeatherFile& weather, const voxel::WorldInfo& world,
                 scene::Scene& scene);

}  // namespace terravox::commands
