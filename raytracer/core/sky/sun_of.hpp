#pragma once

#include <string>

#include "common/geo/sun_position.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::sky {

/// The sun of a scene at a place, its azimuth from the map's north: altitude and azimuth if given,
/// otherwise from date, clock time and place. The clock is that of utc_offset_h, else of the zone,
/// else of the mean solar time of the place's longitude in whole hours.
/// @param place nullptr for worlds that are not georeferenced: latitude 46, longitude 14 are used
/// @throws UsageError for an impossible date or time, an unknown zone, or one angle without the
/// other
[[nodiscard]] geo::SunPosition sun_of(const scene::Scene::Sun& sun, const geo::MapPlace* place,
                                      geo::SunPrecision precision = geo::SunPrecision::kPicture);

/// A date from its text.
/// @param field that holds it, for the message
/// @return midnight of the day, with an offset of 0
/// @throws UsageError unless it is a day of the calendar, as YYYY-MM-DD
[[nodiscard]] geo::DateTime date_of(const std::string& text, const std::string& field);

/// The clock time of a scene's sun at a place, as sun_of() takes it; angles that are given are
/// ignored.
/// @throws UsageError as sun_of()
[[nodiscard]] geo::DateTime time_of(const scene::Scene::Sun& sun, const geo::MapPlace* place);

}  // namespace terravox::sky
