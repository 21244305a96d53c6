#include "raytracer/core/material/waves.hpp"

#include <algorithm>
#include <cmath>

namespace terravox::material {
namespace {

// Sine-like of period 1 with a continuous slope: parabolas. Its highest value is 1.
double swing(double turns) noexcept {
    const double x = turns - std::floor(turns + 0.5);  // [-1/2, 1/2)
    return 16 * x * (0.5 - std::fabs(x));
}

// Waves per metre along x and z, and the slope they reach. Their lengths, 0.9 to 13 m, and
// directions, about a wind from the west-south-west, have no common measure, so that the sum does
// not repeat.
constexpr int kTrains = 8;
constexpr std::array<double, kTrains> kPerX = {0.0713, 0.1319, 0.2137, 0.1873,
                                               0.3511, 0.4943, 0.5519, 0.9277};
constexpr std::array<double, kTrains> kPerZ = {-0.0291, 0.0347, -0.1423, 0.1987,
                                               -0.0529, 0.2713, -0.4177, 0.5881};
constexpr std::array<double, kTrains> kSlope = {0.0050, 0.0062, 0.0066, 0.0058,
                                                0.0072, 0.0062, 0.0058, 0.0050};
constexpr std::array<double, kTrains> kLength_m = {12.98, 7.33, 3.89, 3.66, 2.81, 1.77, 1.44, 0.91};

}  // namespace

std::array<float, 2> water_tilt(double x_m, double z_m, double footprint_m) noexcept {
    // Patches of calm and of ruffled water, some 40 to 90 m.
    const double ruffled =
        0.65 + 0.35 * swing(x_m * 0.0113 + z_m * 0.0067) * swing(z_m * 0.0171 - x_m * 0.0049 + 0.3);
    std::array<double, kTrains> slope{};
    for (std::size_t i = 0; i < kTrains; ++i) {
        // Full strength up to a third of the wave's length.
        const double shown = std::clamp(1.5 - 1.5 * footprint_m / kLength_m[i], 0.0, 1.0);
        slope[i] = swing(x_m * kPerX[i] + z_m * kPerZ[i]) * kSlope[i] * shown * kLength_m[i];
    }
    double x = 0;
    double z = 0;
    for (std::size_t i = 0; i < kTrains; ++i) {
        x += slope[i] * kPerX[i];
        z += slope[i] * kPerZ[i];
    }
    return {static_cast<float>(x * ruffled), static_cast<float>(z * ruffled)};
}

}  // namespace terravox::material
