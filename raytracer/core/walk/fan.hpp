#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "raytracer/core/base/ray.hpp"

namespace terravox::walk {

// A fan is rays from one point in a few directions, of which only matters whether they are free.
// Many points have fans of the same directions: their rays are walked together, direction by
// direction, and while they wait a fan is one TracedRay instead of many.

inline constexpr std::size_t kFanRays = 16;
/// A bit for each direction of a fan, the lowest for the first one.
using FanMask = std::uint16_t;

/// Directions that fans have in common.
struct FanDirections {
    std::array<core::Vec3, kFanRays> to;  ///< of unit length
    std::size_t count = 0;

    void add(const core::Vec3& direction) noexcept { to[count++] = direction; }
};

/// The mask of the first `count` directions, of at most kFanRays.
[[nodiscard]] constexpr FanMask mask_of_first(std::size_t count) noexcept {
    return static_cast<FanMask>((std::uint32_t{1} << count) - 1);
}
[[nodiscard]] constexpr bool has(FanMask mask, std::size_t direction) noexcept {
    return (mask >> direction & 1U) != 0;
}

/// What became of the rays of a fan.
struct FanEnds {
    FanMask blocked = 0;
    FanMask holes = 0;  ///< of the blocked ones, those that met a box that is not available
};

}  // namespace terravox::walk
