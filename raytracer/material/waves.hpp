#pragma once

#include <array>

namespace terravox::material {

/// How a water surface leans at a place: trains of waves, ruffled in patches. Smooth over the whole
/// world, the same for all sizes of voxel; waves that a pixel cannot show are left out.
/// @param x_m, z_m east and south, metres, within 1e8 of the origin
/// @param footprint_m edge of what a pixel covers, metres
/// @return x and z of the normal whose y is 1; each mostly below 0.06
[[nodiscard]] std::array<float, 2> water_tilt(double x_m, double z_m, double footprint_m) noexcept;

}  // namespace terravox::material
