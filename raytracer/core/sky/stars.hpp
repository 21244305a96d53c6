#pragma once

#include "common/voxel/colour.hpp"
#include "raytracer/core/base/ray.hpp"

namespace terravox::sky {

/// The stars: points of a few hundredths of a degree, the same in every picture, about seven
/// hundred above any horizon. They represent a night sky, not that of a given date. Their light on
/// things is negligible and not computed.
/// @param d of unit length
/// @return radiance as a multiple of the night sky's
[[nodiscard]] voxel::Colour starlight(core::Vec3 d) noexcept;

}  // namespace terravox::sky
