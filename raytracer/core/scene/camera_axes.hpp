#pragma once

#include "raytracer/core/base/ray.hpp"

namespace terravox::scene {

/// Axes of a picture: unit vectors at right angles.
struct Axes {
    core::Vec3 forward;
    core::Vec3 right;
    core::Vec3 up;
};

/// The axes of a camera that is held upright; if it looks straight down or up, north is up in the
/// picture.
/// @param forward of unit length
[[nodiscard]] Axes axes_of(core::Vec3 forward) noexcept;

/// The axes turned about the line of sight, clockwise as seen from behind the camera; a turn of 0
/// changes no bit.
[[nodiscard]] Axes rolled(const Axes& axes, double roll_deg) noexcept;

/// Tangent of half a field of view.
[[nodiscard]] double half_of_fov(double fov_deg) noexcept;

}  // namespace terravox::scene
