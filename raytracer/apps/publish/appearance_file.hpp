#pragma once

#include <bit>
#include <cstdint>
#include <string>

#include "raytracer/core/material/appearance.hpp"

namespace terravox::publish {

/// Converts to a half float (IEEE 754 binary16), rounding to the nearest, ties to even. Values
/// beyond 65504 become the largest finite half, since the viewer computes with them; NaN becomes 0.
[[nodiscard]] constexpr std::uint16_t to_half(float value) noexcept {
    constexpr std::uint32_t kLargest = 0x7bff;
    constexpr float kMax = 65504.0f;
    constexpr float kSmallestNormal = 0x1p-14f;
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
    const std::uint32_t sign = bits >> 16 & 0x8000;
    const float size = std::bit_cast<float>(bits & 0x7fffffff);
    if (!(size == size))
        return 0;
    if (size >= kMax)
        return static_cast<std::uint16_t>(sign | kLargest);
    if (size < kSmallestNormal) {
        // Adding this number lets the hardware round to multiples of the smallest half.
        const std::uint32_t rounded =
            std::bit_cast<std::uint32_t>(size + 0.5f) - std::bit_cast<std::uint32_t>(0.5f);
        return static_cast<std::uint16_t>(sign | rounded);
    }
    const std::uint32_t own = std::bit_cast<std::uint32_t>(size);
    const std::uint32_t rounded = own + 0xfff + (own >> 13 & 1);
    return static_cast<std::uint16_t>(sign | ((rounded - 0x38000000) >> 13));
}

/// The air of a place, as in Scene::Sky.
struct AirOptions {
    double turbidity = 2.5;     ///< [1, 20]
    double place_height_m = 0;  ///< of the world's lowest voxel above the sea, [0, 10000]
};

/// What the web viewer needs of materials and the sky: `appearance.bin` (docs/formats/site.md).
/// Materials with their drawings and windows as MaterialTable has them; the clear sky for several
/// altitudes of the sun as Dome has it, on a coarser grid; sunlight, haze, and the night's glow.
/// Compressed as gzip, which browsers unpack.
/// A pure function of its arguments. Takes about a second: the sky is computed once for each
/// altitude.
[[nodiscard]] std::string appearance_file(const material::MaterialAppearances& appearances,
                                          const AirOptions& air);

}  // namespace terravox::publish
