#pragma once

#include <cstdint>

#include "common/util/linear_light.hpp"
#include "common/voxel/material.hpp"

namespace terravox::bench {

/// A channel of sRGB as light, [0, 1].
[[nodiscard]] inline double linear_of(std::uint8_t value) {
    return static_cast<double>(util::to_linear(value)) / util::kBrightest;
}

/// Relative luminance, [0, 1]. Ref: IEC 61966-2-1.
[[nodiscard]] inline double luminance_of(voxel::Rgb8 c) {
    return 0.2126 * linear_of(c.r) + 0.7152 * linear_of(c.g) + 0.0722 * linear_of(c.b);
}

}  // namespace terravox::bench
