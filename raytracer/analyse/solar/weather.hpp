#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/geo/lat_lon.hpp"
#include "raytracer/analyse/solar/energy.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::solar {

/// Light that an hour brings, Wh/m2.
struct WeatherHour {
    double global = 0;   ///< on a level surface
    double beam = 0;     ///< of the sun, on a surface that faces it
    double diffuse = 0;  ///< of the sky, on a level surface
};

/// A year of hours, of one place.
struct WeatherFile {
    std::string name;  ///< of the place, as the file has it
    geo::LatLon place;
    double offset_h = 0;             ///< of the file's clock, which knows no summer time, to UTC
    std::vector<WeatherHour> hours;  ///< from midnight on; of 365 or 366 days

    /// The hour of an instant by the file's calendar: 29 February is 28 February where the file has
    /// none.
    /// @param hour_of_time hours since 1970-01-01 00:00 by the file's clock
    [[nodiscard]] const WeatherHour& at(std::int64_t hour_of_time) const;
};

/// Reads a weather file of EnergyPlus: EPW, with one value an hour, which is that of the hour
/// before its time.
/// Ref: EnergyPlus, "Auxiliary Programs", chapter "EnergyPlus Weather File (EPW) Data Dictionary".
/// @throws Error naming the file, and the line where it is one's fault: when it cannot be read, is
/// no EPW, is not a whole year from 1 January on, or lacks radiation
[[nodiscard]] WeatherFile read_weather(const std::filesystem::path& file);

/// The light of a period by a weather file.
struct WeatherLight {
    Energy energy;
    /// On a level surface, kWh/m2: as the sums have it, and as the file has it. They differ where
    /// the sun is not where it was when the file's light came.
    double level = 0;
    double global = 0;
};

/// Sums up the light of a scene's analysis. Each hour's light is spread evenly over those of its
/// steps in which the sun is up; that of the sky while it is down comes evenly from everywhere. The
/// file's year stands for every year.
///
/// Hours of sunshine are those with at least 120 W/m2 from the sun.
/// Ref: WMO, "Guide to Instruments and Methods of Observation", chapter 8.
/// @throws UsageError as find_period() and each_sun_step(); for steps that do not fill an hour
[[nodiscard]] WeatherLight weather_light(const scene::Scene& scene, const geo::MapPlace& place,
                                         const WeatherFile& weather);

/// Puts the light of a weather file into a scene. Warns where the file is of a place far away, and
/// where its light does not fit the sun.
/// @param place of the data
/// @throws UsageError as weather_light() and to_text()
void use_weather(const WeatherFile& weather, const geo::MapPlace& place, scene::Scene& scene);

}  // namespace terravox::solar
