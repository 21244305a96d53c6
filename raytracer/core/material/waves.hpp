#pragma once

#include <array>

namespace terravox::material {

/// The tilt of a water surface at a point: trains of waves, ruffled in patches. Smooth over the
/// whole world and independent of the voxel size; waves too short for a pixel are left out.
/// @param x_m, z_m east and south, metres, within 1e8 of the origin
/// @param footprint_m edge of what a pixel covers, metres
/// @return x and z of the normal whose y is 1; each usually below 0.06
[[nodiscard]] std::array<float, 2> water_tilt(double x_m, double z_m, double footprint_m) noexcept;

}  // namespace terravox::material
