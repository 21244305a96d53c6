#pragma once

#include <bit>
#include <cstdint>

#include "common/voxel/material.hpp"

namespace terravox::imagery {

/// CIELAB with the D65 white point: `l` in [0, 100], `a` (green to red) and `b` (blue to yellow)
/// about -110 to 110.
struct Lab {
    double l = 0;
    double a = 0;
    double b = 0;
};

/// Cube root of x >= 1e-6, relative error below 1e-12; the same bits on every machine (see
/// common/util/det_math.hpp). Two steps of Halley's method from an initial estimate that divides
/// the exponent by three.
[[nodiscard]] constexpr double cube_root(double x) noexcept {
    constexpr std::uint64_t kThirdOfBias =
        std::uint64_t{0x2A9F7893}
        << 32;  // two thirds of the exponent's bias, adjusted to balance the estimate's error
    double y = std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) / 3 + kThirdOfBias);
    for (int i = 0; i < 2; ++i) {
        const double cube = y * y * y;
        y = y * (cube + 2 * x) / (2 * cube + x);
    }
    return y;
}

/// Converts sRGB to CIELAB. Ref: IEC 61966-2-1 (sRGB) and CIE 15 (colorimetry), with the white
/// point that results from sRGB's own primaries.
[[nodiscard]] Lab to_lab(voxel::Rgb8 colour) noexcept;

}  // namespace terravox::imagery
