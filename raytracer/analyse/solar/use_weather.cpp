#include "raytracer/analyse/solar/use_weather.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/det_math.hpp"
#include "common/util/log.hpp"
#include "raytracer/analyse/solar/light_list.hpp"
#include "raytracer/analyse/solar/weather_light.hpp"

namespace terravox::solar {
namespace {

/// Along a great circle.
double distance_km(const geo::LatLon& a, const geo::LatLon& b) {
    constexpr double kRad = det::kPi / 180;
    constexpr double kEarth_km = 6371;
    const double north = std::sin((b.lat_deg - a.lat_deg) * kRad / 2);
    const double east = std::sin((b.lon_deg - a.lon_deg) * kRad / 2);
    const double part =
        north * north + std::cos(a.lat_deg * kRad) * std::cos(b.lat_deg * kRad) * east * east;
    return 2 * kEarth_km * std::asin(std::sqrt(std::min(part, 1.0)));
}

}  // namespace

void use_weather(const WeatherFile& weather, const geo::MapPlace& place, scene::Scene& scene) {
    constexpr double kFar_km = 50;
    const double far_km = distance_km(weather.place, place);
    if (far_km > kFar_km)
        util::log_warn(
            "the weather is that of {}, {:.0f} km from the data; up to {:.0f} km is near",
            weather.name, far_km, kFar_km);
    const WeatherLight light = weather_light(scene, place, weather);
    constexpr double kTolerance = 0.1;
    if (std::abs(light.level - light.global) > kTolerance * light.global)
        util::log_warn(
            "light of the weather file does not fit the sun: direct and diffuse light are {:.1f} "
            "kWh/m2 on level ground, global light is {:.1f}; is its time zone right?",
            light.level, light.global);
    scene.analysis.light = text_of(light.energy);
}

}  // namespace terravox::solar
