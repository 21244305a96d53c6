#pragma once

#include "common/geo/lat_lon.hpp"
#include "raytracer/analyse/solar/weather_file.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::solar {

/// Puts the light of a weather file into a scene. Warns where the file is of a place far away, and
/// where its light does not fit the sun.
/// @param place of the data
/// @throws UsageError as weather_light() and text_of()
void use_weather(const WeatherFile& weather, const geo::MapPlace& place, scene::Scene& scene);

}  // namespace terravox::solar
