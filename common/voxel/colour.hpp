#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "common/util/det_math.hpp"
#include "common/voxel/material.hpp"

namespace terravox::voxel {

/// Linear light, Rec. 709 primaries; 1 = a white surface in full daylight.
struct Colour {
    float r = 0;
    float g = 0;
    float b = 0;
    friend Colour operator+(Colour x, Colour y) noexcept {
        return {x.r + y.r, x.g + y.g, x.b + y.b};
    }
    friend Colour operator*(Colour x, Colour y) noexcept {
        return {x.r * y.r, x.g * y.g, x.b * y.b};
    }
    friend Colour operator*(Colour a, float s) noexcept { return {a.r * s, a.g * s, a.b * s}; }
};
[[nodiscard]] inline float luminance(Colour c) noexcept {
    return 0.2126f * c.r + 0.7152f * c.g + 0.0722f * c.b;
}
[[nodiscard]] inline Colour mix(Colour a, Colour b, float t) noexcept {
    return a * (1 - t) + b * t;
}

/// Ref: IEC 61966-2-1 (sRGB).
[[nodiscard]] inline float srgb_to_linear(std::uint8_t v) noexcept {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> out{};
        for (int i = 0; i < 256; ++i) {
            const double c = i / 255.0;
            out[static_cast<std::size_t>(i)] =
                static_cast<float>(c <= 0.04045 ? c / 12.92 : det::pow((c + 0.055) / 1.055, 2.4));
        }
        return out;
    }();
    return table[v];
}
/// Accurate to 1e-4, a fortieth of an 8-bit step: linear interpolation between the 4097 entries of
/// a table over the square root of c, where the curve is nearly straight.
[[nodiscard]] inline float linear_to_srgb(float c) noexcept {
    constexpr int kSteps = 4096;
    static const std::array<float, kSteps + 2> table = [] {
        std::array<float, kSteps + 2> out{};
        for (int i = 0; i <= kSteps + 1; ++i) {
            const double root = static_cast<double>(i) / kSteps;
            const double linear = root * root;
            out[static_cast<std::size_t>(i)] = static_cast<float>(
                linear <= 0.0031308 ? linear * 12.92 : 1.055 * det::pow(linear, 1 / 2.4) - 0.055);
        }
        return out;
    }();
    if (!(c > 0))
        return 0;
    if (c >= 1)
        return 1;
    const float at = std::sqrt(c) * kSteps;
    const auto i = static_cast<std::size_t>(at);
    return table[i] + (table[i + 1] - table[i]) * (at - static_cast<float>(i));
}
[[nodiscard]] inline Colour to_linear(voxel::Rgb8 c) noexcept {
    return {srgb_to_linear(c.r), srgb_to_linear(c.g), srgb_to_linear(c.b)};
}

}  // namespace terravox::voxel
