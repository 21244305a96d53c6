#include "raytracer/analyse/solar/energy.hpp"

#include <array>
#include <cmath>

#include "common/util/det_math.hpp"
#include "common/util/error.hpp"
#include "raytracer/analyse/solar/clear_sky.hpp"
#include "raytracer/analyse/solar/light_list.hpp"
#include "raytracer/analyse/solar/light_sums.hpp"

namespace terravox::solar {
namespace {

/// Points of a spiral: each has the same height of the half sphere, and so the same solid angle.
std::vector<core::Vec3> sky_directions(int count) {
    constexpr double kGoldenAngle = 2.39996322972865332;
    std::vector<core::Vec3> out;
    out.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        const double y = (i + 0.5) / count;
        const det::SinCos azimuth = det::sin_cos(i * kGoldenAngle);
        const double level = std::sqrt(1 - y * y);
        out.push_back({level * azimuth.cos, y, level * azimuth.sin});
    }
    return out;
}

}  // namespace

Energy energy_of(const scene::Scene& scene, const geo::MapPlace* place, double height_m) {
    if (!scene.analysis.light.empty()) {
        Energy given = light_of(scene.analysis.light);
        given.sky = sky_directions(scene.analysis.directions);
        return given;
    }
    if (place == nullptr)
        throw util::UsageError(
            "light the sky: the world has no place on Earth; allowed: worlds "
            "with a CRS");
    const std::array<double, 12> linke = linke_of(scene.analysis.linke);
    LightSums sums(scene, *place);
    each_sun_step(scene, *place, [&](const SunStep& step) {
        const double haze = linke[static_cast<std::size_t>(step.clock.month - 1)];
        sums.add(step, clear_sky(step.sun.altitude_deg, haze, height_m, day_number(step.clock)),
                 step.hours);
    });
    Energy out = sums.take();
    out.sky = sky_directions(scene.analysis.directions);
    return out;
}

}  // namespace terravox::solar
