#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/geo/sun_position.hpp"

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

}  // namespace terravox::solar
