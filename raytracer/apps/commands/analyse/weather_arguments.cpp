#include "raytracer/apps/commands/analyse/weather_arguments.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>

#include "common/util/error.hpp"

namespace terravox::commands {
void add_weather_option(CLI::App& command, std::string& file) {
    command.add_option("--weather", file,
                       "EPW file: light of a year's hours by its weather, instead of a sky without "
                       "clouds");
}

std::optional<solar::WeatherFile> read_weather(const std::string& file,
                                               const WorldArguments& world) {
    if (file.empty())
        return std::nullopt;
    const bool has_linke =
        std::any_of(world.fields.begin(), world.fields.end(),
                    [](const auto& field) { return field.first == "analysis.linke"; });
    if (has_linke)
        throw util::UsageError(
            "analyse energy: --weather together with --linke; allowed: one of them");
    return solar::read_weather(file);
}

}  // namespace terravox::commands
