#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/geo/lat_lon.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/analyse/solar/weather.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Up to so many bands, which is each quarter of an hour of a day, or each hour of four days.
inline constexpr std::size_t kMaxTimes = 96;

/// One of the instants of `analyse sun --times`.
struct ClockTime {
    std::string date;  ///< YYYY-MM-DD; empty: that of the scene
    double hour = 0;   ///< on the scene's clock
    std::string band;  ///< name of its band, such as sunlit_0900 or sunlit_2026-06-21T0900
};

/// Reads HH:MM or YYYY-MM-DDTHH:MM, several separated by commas.
/// @throws UsageError for none or more than kMaxTimes, for one that is given twice, and for what is
/// no time
[[nodiscard]] std::vector<ClockTime> parse_clock_times(const std::string& text);

/// When the sun of a scene is, as seconds since 1970-01-01 00:00 UTC.
/// @throws UsageError as sky::to_time()
[[nodiscard]] std::int64_t find_instant(const scene::Scene& scene, const geo::MapPlace& place);

/// The scene with the sun of an instant.
[[nodiscard]] scene::Scene scene_at(const scene::Scene& scene, const ClockTime& time);

/// Arguments of `analyse sun` that are no fields of a scene.
struct SunArguments {
    std::string at;
    std::string times;  ///< as typed
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

/// @param file to be set: an EPW file, or empty
void add_weather_option(CLI::App& command, std::string& file);

/// Reads the weather file of a command line.
/// @param world with the fields that were given on the command line
/// @return nullopt where none is given
/// @throws UsageError together with a turbidity; Error as solar::read_weather()
[[nodiscard]] std::optional<solar::WeatherFile> read_weather(const std::string& file,
                                                             const WorldArguments& world);

/// Terrain outside of the data, on a command line.
struct HorizonArguments {
    std::string file;  ///< raster of heights; empty: the horizon is free
    double range_km = 60;
};

void add_horizon_options(CLI::App& command, HorizonArguments& args);

/// @param scene of the analysis
/// @throws UsageError where rays end before the horizon
void check_horizon_arguments(const HorizonArguments& args, const scene::Scene& scene);

/// Puts the terrain into a scene, if there is any.
/// @throws as analyse::look_at_horizon()
void use_horizon(const HorizonArguments& args, const voxel::WorldInfo& world, scene::Scene& scene);

}  // namespace terravox::commands
