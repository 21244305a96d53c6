#pragma once

#include <cstdint>

namespace terravox::survey {

/// Smooth noise of one variable, about [-1, 1], features one unit wide. A function of seed and
/// place only.
[[nodiscard]] double noise_1d(std::uint64_t seed, double x) noexcept;

/// Gradient noise of two variables, about [-1, 1], features one unit wide.
/// Ref: Perlin, "Improving Noise", SIGGRAPH 2002.
[[nodiscard]] double noise_2d(std::uint64_t seed, double x, double y) noexcept;

/// The sum of `octaves` noises, each twice as fine and half as high as the one before; about [-1,
/// 1].
[[nodiscard]] double fractal_2d(std::uint64_t seed, double x, double y, int octaves) noexcept;

}  // namespace terravox::survey
