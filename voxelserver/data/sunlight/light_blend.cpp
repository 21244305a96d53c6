#include "voxelserver/data/sunlight/light_blend.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/det_math.hpp"

namespace terravox::sunlight {
namespace {

constexpr double kRadian_deg = 180 / det::kPi;

/// A direction as a unit vector: east, north, up.
using Direction = std::array<double, 3>;

Direction direction_of(const Sun& sun) noexcept {
    const double level = det::cos(sun.altitude_deg / kRadian_deg);
    return {level * det::sin(sun.azimuth_deg / kRadian_deg),
            level * det::cos(sun.azimuth_deg / kRadian_deg),
            det::sin(sun.altitude_deg / kRadian_deg)};
}

Sun sun_of(const Direction& to) noexcept {
    const double level = std::sqrt(to[0] * to[0] + to[1] * to[1]);
    const double azimuth_deg = det::atan2(to[0], to[1]) * kRadian_deg;
    return {azimuth_deg < 0 ? azimuth_deg + 360 : azimuth_deg,
            det::atan2(to[2], level) * kRadian_deg};
}

LightField::Levels levels_of(const FlightLight& light) noexcept {
    return {light.sky, light.veil, light.gain};
}

}  // namespace

bool is_same_flight(const Sun& a, const Sun& b) noexcept {
    constexpr double kApart_deg = 5;
    const Direction to_a = direction_of(a);
    const Direction to_b = direction_of(b);
    return to_a[0] * to_b[0] + to_a[1] * to_b[1] + to_a[2] * to_b[2] >=
           det::cos(kApart_deg / kRadian_deg);
}

FlightLight blended(std::span<const WeightedLight> lights) {
    if (lights.size() == 1)
        return lights.front().light;
    FlightLight out;
    out.sky = out.veil = out.gain = {};
    Direction sun{};
    float sum = 0;
    std::array<float, kKinds> known{};
    for (const WeightedLight& one : lights) {
        const Direction to = direction_of(*one.light.sun);
        for (std::size_t c = 0; c < 3; ++c) {
            sun[c] += static_cast<double>(one.weight) * to[c];
            out.sky[c] += one.weight * one.light.sky[c];
            out.veil[c] += one.weight * one.light.veil[c];
            out.gain[c] += one.weight * one.light.gain[c];
        }
        sum += one.weight;
        for (std::size_t k = 0; k < kKinds; ++k)
            if (one.light.typical[k] > 0) {
                out.typical[k] += one.weight * one.light.typical[k];
                known[k] += one.weight;
            }
    }
    for (std::size_t c = 0; c < 3; ++c) {
        out.sky[c] /= sum;
        out.veil[c] /= sum;
        out.gain[c] /= sum;
    }
    for (std::size_t k = 0; k < kKinds; ++k)
        if (known[k] > 0)
            out.typical[k] /= known[k];
    out.sun = sun_of(sun);
    return out;
}

LightField::LightField(const FlightLight& light) noexcept
    : middle(light),
      corners{levels_of(light), levels_of(light), levels_of(light), levels_of(light)} {}

LightField::LightField(const FlightLight& of_middle,
                       const std::array<FlightLight, 4>& of_corners) noexcept
    : middle(of_middle),
      corners{levels_of(of_corners[0]), levels_of(of_corners[1]), levels_of(of_corners[2]),
              levels_of(of_corners[3])} {}

LightField::Levels LightField::at(float east, float south) const noexcept {
    const auto mix = [&](const Light Levels::* of) {
        Light out{};
        for (std::size_t c = 0; c < 3; ++c) {
            const auto along = [&](std::size_t west) {
                const float from = (corners[west].*of)[c];
                return from + east * ((corners[west + 1].*of)[c] - from);
            };
            const float north = along(0);
            out[c] = north + south * (along(2) - north);
        }
        return out;
    };
    return {mix(&Levels::sky), mix(&Levels::veil), mix(&Levels::gain)};
}

}  // namespace terravox::sunlight
