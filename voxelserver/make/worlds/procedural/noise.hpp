#pragma once

#include <cstdint>

#include "common/util/mix.hpp"

namespace terravox::procedural {

using util::mix;

/// Derives the seed of one of several features that must be uncorrelated.
[[nodiscard]] constexpr std::uint64_t make_seed(std::uint64_t seed, int thing) noexcept {
    return mix(seed ^ mix(static_cast<std::uint64_t>(thing)));
}

/// A hash of a place on some grid.
[[nodiscard]] constexpr std::uint64_t place_hash(std::uint64_t seed, std::int32_t x,
                                                 std::int32_t z) noexcept {
    return mix(seed ^ (std::uint64_t{static_cast<std::uint32_t>(x)} << 32 |
                       static_cast<std::uint32_t>(z)));
}

/// Bits [12 part, 12 part + 12) of a hash as a number in [0, 1); part in [0, 5).
[[nodiscard]] constexpr double to_unit(std::uint64_t hash, int part) noexcept {
    return static_cast<double>(hash >> (12 * part) & 0xFFF) * 0x1p-12;
}

/// Simplex noise: smooth, in [-1, 1], mean 0, features about one unit wide, no visible grid. A
/// function of its arguments only, with the same bits on every machine of IEEE arithmetic: + - *
/// and integers. Coordinates within +-2^40.
/// Ref: Gustavson, "Simplex noise demystified", 2005; gradients by a hash of the corner instead of
/// a table of permutations, so nothing repeats.
[[nodiscard]] double simplex(std::uint64_t seed, double x, double y) noexcept;
[[nodiscard]] double simplex(std::uint64_t seed, double x, double y, double z) noexcept;

}  // namespace terravox::procedural
