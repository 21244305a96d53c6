#pragma once

#include "raytracer/core/ray.hpp"

namespace terravox::scene {

/// Of a picture: unit vectors at right angles.
struct Axes {
    core::Vec3 forward, right, up;
};

/// The axes of a camera that is held upright; of one that looks straight down or up, north is up in
/// the picture.
/// @param forward of unit length
[[nodiscard]] Axes axes_of(core::Vec3 forward) noexcept;

/// The camera turned about its line of sight, clockwise as seen from behind it; by 0 the same to
/// the last bit.
[[nodiscard]] Axes rolled(const Axes& axes, double roll_deg) noexcept;

/// Tangent of half a field of view.
[[nodiscard]] double half_of_fov(double fov_deg) noexcept;

}  // namespace terravox::scene
