#pragma once

#include <algorithm>

#include "common/geo/lat_lon.hpp"
#include "raytracer/analyse/solar/sky_light.hpp"
#include "raytracer/analyse/solar/sun_way.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/core/sky/sun.hpp"
#include "tests/raytracer/analyse/evaluators/measured.hpp"

namespace terravox::test {

inline constexpr geo::MapPlace kTown{46, 14.5};

/// The scene of an analysis of energy, in kTown, under an even sky without clouds.
inline scene::Scene energy_scene(core::AnalysisKind kind, const char* from, const char* to) {
    scene::Scene scene = analysis_scene(kind);
    scene.sun.utc_offset_h = 1;
    scene.analysis.from = from;
    scene.analysis.to = to;
    scene.analysis.step_min = 30;
    scene.analysis.diffuse = "isotropic";
    return scene;
}

/// Light of a period on a plane with a free sky, kWh/m2.
struct Light {
    double beam = 0;
    double diffuse = 0;
    double reflected = 0;
};

/// The sum over all steps of the period, without bins.
/// @param scene of 2026, as above
/// @param normal of unit length; x east, y up, z south
inline Light in_the_open(const scene::Scene& scene, core::Vec3 normal, double height_m) {
    Light out;
    double level = 0;
    solar::each_sun_step(scene, kTown, [&](const solar::SunStep& step) {
        const int day = static_cast<int>((step.middle_s + 3600) / 86'400 - 20'453);  // of 2026
        const solar::Irradiance light = solar::clear_sky(step.sun.altitude_deg, 3, height_m, day);
        const core::Vec3 to = sky::Sun(step.sun, 0).direction();
        const double kilohours = step.hours / 1000;
        out.beam += light.beam * std::max(core::dot(normal, to), 0.0) * kilohours;
        out.diffuse += light.diffuse * (1 + normal.y) / 2 * kilohours;
        level += (light.beam * to.y + light.diffuse) * kilohours;
    });
    out.reflected = scene.analysis.albedo * level * (1 - normal.y) / 2;
    return out;
}

}  // namespace terravox::test
