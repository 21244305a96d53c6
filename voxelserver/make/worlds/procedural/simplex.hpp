#pragma once

#include <cstdint>

namespace terravox::procedural {

/// Simplex noise: smooth, in [-1, 1], mean 0, features about one unit wide, no visible grid. A
/// function of its arguments only, with the same bits on every machine of IEEE arithmetic: + - *
/// and integers. Coordinates within +-2^40.
/// Ref: Gustavson, "Simplex noise demystified", 2005; gradients by a hash of the corner instead of
/// a table of permutations, so nothing repeats.
[[nodiscard]] double simplex(std::uint64_t seed, double x, double y) noexcept;
[[nodiscard]] double simplex(std::uint64_t seed, double x, double y, double z) noexcept;

}  // namespace terravox::procedural
