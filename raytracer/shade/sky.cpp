#include "raytracer/shade/sky.hpp"

#include <chrono>
#include <cmath>
#include <numbers>
#include <string>

#include "common/util/error.hpp"

namespace terravox {
namespace {

constexpr double kRad = std::numbers::pi / 180;

float smooth(double low, double high, double v) noexcept {
    const double t = std::clamp((v - low) / (high - low), 0.0, 1.0);
    return static_cast<float>(t * t * (3 - 2 * t));
}

}  // namespace

Sky::Sky(const geo::SunPosition& sun, const Scene::Sun& sun_settings, const Scene::Sky& sky_settings) {
    const double altitude = sun.altitude_deg * kRad, azimuth = sun.azimuth_deg * kRad;
    m_to_sun = normalized({std::sin(azimuth) * std::cos(altitude), std::sin(altitude), -std::cos(azimuth) * std::cos(altitude)});
    // Low light is dimmer and redder: it has passed more air.
    const float day = smooth(-6, 12, sun.altitude_deg), high = smooth(0, 35, sun.altitude_deg), up = smooth(-0.8, 3, sun.altitude_deg);
    const auto strength = static_cast<float>(sun_settings.strength), sky = static_cast<float>(sky_settings.strength) * (0.03f + 0.97f * day);
    m_sun_light = mix({1.9f, 0.95f, 0.42f}, {2.55f, 2.38f, 2.10f}, high) * (strength * up);
    m_zenith = mix({0.10f, 0.15f, 0.30f}, {0.17f, 0.36f, 0.74f}, high) * sky;
    m_horizon = mix({0.95f, 0.62f, 0.40f}, {0.92f, 1.02f, 1.14f}, high) * sky;
    m_ground = m_horizon * 0.92f;
    constexpr double kLeftOver = 0.05;
    m_extinction_per_m = -std::log(kLeftOver) / (sky_settings.visibility_km.value_or(100) * 1000);
}

Colour Sky::radiance(Vec3 d) const noexcept {
    if (d.y < 0) {
        // Below the horizon: haze that darkens downwards, a quiet backdrop for the model.
        const auto t = static_cast<float>(std::min(1.0, -d.y * 1.6));
        return mix(m_horizon, m_ground * 0.72f, t);
    }
    const auto t = static_cast<float>(std::sqrt(d.y));
    const Colour base = mix(m_horizon, m_zenith, t);
    // A glow around the sun, from light that the air scatters forward.
    const double c = std::max(0.0, dot(d, m_to_sun));
    const double c4 = c * c * c * c, c16 = c4 * c4 * c4 * c4, c64 = c16 * c16 * c16 * c16;
    const auto glow = static_cast<float>(0.06 * c4 + 0.12 * c64);
    return base + m_sun_light * glow;
}

Colour Sky::ambient(Vec3 n) const noexcept {
    const auto up = static_cast<float>(0.5 + 0.5 * n.y);
    const Colour from_sky = mix(m_horizon, m_zenith, 0.6f) * 0.80f;
    // What lies around throws some of the sun's light back up.
    const Colour from_ground = (m_sun_light * (0.10f * static_cast<float>(std::max(0.0, m_to_sun.y))) + m_zenith * 0.15f) * Colour{1.0f, 0.92f, 0.78f};
    return from_sky * up + from_ground * (1 - up);
}

float Sky::haze(double metres) const noexcept { return static_cast<float>(1 - det::exp(-metres * m_extinction_per_m)); }

geo::SunPosition sun_of(const Scene::Sun& sun, const geo::LatLon* place) {
    if (sun.altitude_deg.has_value() != sun.azimuth_deg.has_value())
        throw UsageError(std::string("place the sun: sun.") + (sun.altitude_deg ? "azimuth_deg" : "altitude_deg") + " is missing; give both, or none to use date and time");
    if (sun.altitude_deg) return {*sun.altitude_deg, *sun.azimuth_deg};
    geo::DateTime time;
    int end = 0;
    if (std::sscanf(sun.date.c_str(), "%4d-%2d-%2d%n", &time.year, &time.month, &time.day, &end) != 3 || static_cast<std::size_t>(end) != sun.date.size() ||
        !std::chrono::year_month_day{std::chrono::year(time.year), std::chrono::month(static_cast<unsigned>(time.month)), std::chrono::day(static_cast<unsigned>(time.day))}.ok())
        throw UsageError("place the sun: sun.date = '" + sun.date + "'; allowed: YYYY-MM-DD");
    const geo::LatLon here = place != nullptr ? *place : geo::LatLon{46, 14};
    time.hour = sun.time_h;
    time.utc_offset_h = sun.utc_offset_h.value_or(geo::solar_zone_offset_h(here.lon_deg));
    return geo::sun_position(time, here);
}

}  // namespace terravox
