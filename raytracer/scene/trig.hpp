#pragma once

#include <cmath>
#include <numbers>

namespace terravox::trig {

/// The one place where cameras and animations take their angle functions from. Their values reach pixels.
[[nodiscard]] inline double sin(double rad) noexcept { return std::sin(rad); }
[[nodiscard]] inline double cos(double rad) noexcept { return std::cos(rad); }
[[nodiscard]] inline double tan(double rad) noexcept { return std::tan(rad); }

inline constexpr double kRadPerDeg = std::numbers::pi / 180;

}  // namespace terravox::trig
