#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "raytracer/core/sky/atmosphere.hpp"
#include "raytracer/core/sky/sky.hpp"
#include "tests/catch.hpp"

namespace terravox::test {

inline double brightness(voxel::Colour c) {
    return static_cast<double>(voxel::luminance(c));
}

inline bool good(voxel::Colour c) {
    return c.r >= 0 && c.g >= 0 && c.b >= 0 && std::isfinite(c.r) && std::isfinite(c.g) &&
           std::isfinite(c.b);
}

/// The default scene's sky at sea level.
inline sky::Sky sky_at(double altitude_deg, double azimuth_deg = 180,
                       const scene::Scene::Sky& settings = {}) {
    return {{altitude_deg, azimuth_deg}, scene::Scene::Sun{}, settings, 0};
}

inline scene::Scene::Sky with_clouds(double cover) {
    scene::Scene::Sky sky;
    sky.clouds = cover;
    return sky;
}

inline core::Vec3 direction(double altitude_deg, double azimuth_deg) {
    const auto e = det::sin_cos(altitude_deg * det::kPi / 180);
    const auto a = det::sin_cos(azimuth_deg * det::kPi / 180);
    return {a.sin * e.cos, e.sin, -a.cos * e.cos};
}

inline std::vector<core::Vec3> directions(int count, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::vector<core::Vec3> out = {{0, 1, 0}, {0, -1, 0}, {1, 0, 0},      {-1, -0.0, 0},
                                   {0, 0, 1}, {0, 0, -1}, {1, 1e-300, 0}, {0, -1e-300, 1}};
    while (out.size() < static_cast<std::size_t>(count))
        out.push_back(core::normalized({normal(random), normal(random), normal(random)}));
    return out;
}

/// Calls visit(direction, solid angle) for about `count` directions that share the sphere (sine of
/// the elevation in [low, 1]) evenly. Ref: Gonzalez, "Measurement of areas on a sphere using
/// Fibonacci and latitude-longitude lattices", 2010.
template <class Visit>
void over_sphere(int count, double low, Visit&& visit) {
    for (int i = 0; i < count; ++i) {
        const double y = low + (1 - low) * (i + 0.5) / count;
        const double flat = std::sqrt(1 - y * y);
        const double turn = 2 * det::kPi * i * 0.6180339887498949;
        visit(core::Vec3{flat * std::cos(turn), y, flat * std::sin(turn)},
              2 * det::kPi * (1 - low) / count);
    }
}

}  // namespace terravox::test
