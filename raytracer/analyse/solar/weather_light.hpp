#pragma once

#include "raytracer/analyse/solar/energy.hpp"
#include "raytracer/analyse/solar/weather_file.hpp"

namespace terravox::solar {

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
/// @throws UsageError as period_of() and each_sun_step(); for steps that do not fill an hour
[[nodiscard]] WeatherLight weather_light(const scene::Scene& scene, const geo::MapPlace& place,
                                         const WeatherFile& weather);

}  // namespace terravox::solar
