#pragma once

#include "common/util/det_math.hpp"

namespace terravox::scene::trig {

/// The only angle functions that cameras and animations use, because their values affect pixels.
[[nodiscard]] inline double sin(double rad) noexcept {
    return det::sin(rad);
}
[[nodiscard]] inline double cos(double rad) noexcept {
    return det::cos(rad);
}
[[nodiscard]] inline double tan(double rad) noexcept {
    return det::tan(rad);
}

inline constexpr double kRadPerDeg = det::kPi / 180;

}  // namespace terravox::scene::trig
