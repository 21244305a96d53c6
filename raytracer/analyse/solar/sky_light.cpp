#include "raytracer/analyse/solar/sky_light.hpp"

#include <algorithm>
#include <iterator>

#include "common/util/det_math.hpp"

namespace terravox::solar {
namespace {

/// A class of skies from overcast to clear, and its coefficients.
struct SkyClass {
    double max_clearness;
    double f1[3];
    double f2[3];
};
constexpr SkyClass kClasses[] = {
    {1.065, {-0.008, 0.588, -0.062}, {-0.060, 0.072, -0.022}},
    {1.230, {0.130, 0.683, -0.151}, {-0.019, 0.066, -0.029}},
    {1.500, {0.330, 0.487, -0.221}, {0.055, -0.064, -0.026}},
    {1.950, {0.568, 0.187, -0.295}, {0.109, -0.152, -0.014}},
    {2.800, {0.873, -0.392, -0.362}, {0.226, -0.462, 0.001}},
    {4.500, {1.132, -1.237, -0.412}, {0.288, -0.823, 0.056}},
    {6.200, {1.060, -1.600, -0.359}, {0.264, -1.127, 0.131}},
    {1e300, {0.678, -0.327, -0.250}, {0.156, -1.377, 0.251}},
};

const SkyClass& class_of(double clearness) noexcept {
    std::size_t i = 0;
    while (clearness >= kClasses[i].max_clearness && i + 1 < std::size(kClasses))
        ++i;
    return kClasses[i];
}

double weighted(const double (&f)[3], double brightness, double zenith) noexcept {
    return f[0] + f[1] * brightness + f[2] * zenith;
}

}  // namespace

SkyLight isotropic_light(const Irradiance& light) noexcept {
    return {light.diffuse, 0, 0};
}

SkyLight perez_light(const Irradiance& light, double altitude_deg,
                     double extraterrestrial_w_m2) noexcept {
    if (light.diffuse <= 0)
        return {};
    constexpr double kRad = det::kPi / 180;
    const double zenith = (90 - altitude_deg) * kRad;
    const double cubed = 1.041 * zenith * zenith * zenith;
    const double clearness = ((light.diffuse + light.beam) / light.diffuse + cubed) / (1 + cubed);
    const double brightness = light.diffuse * air_mass(altitude_deg) / extraterrestrial_w_m2;
    const SkyClass& sky = class_of(clearness);
    const double around_sun = std::max(0.0, weighted(sky.f1, brightness, zenith));
    const double horizon = weighted(sky.f2, brightness, zenith);
    constexpr double kLowest_deg = 5;
    const double sine = det::sin(std::max(altitude_deg, kLowest_deg) * kRad);
    return {light.diffuse * (1 - around_sun), light.diffuse * around_sun / sine,
            light.diffuse * horizon};
}

}  // namespace terravox::solar
