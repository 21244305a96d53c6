#pragma once

#include <cstdint>

#include "voxelserver/survey/geotiff.hpp"
#include "voxelserver/survey/square_model.hpp"

namespace terravox::survey {

inline constexpr double kOrthophotoPixel_m = 0.5;

/// Paints the square from straight above (a true orthophoto: no objects lean), three bands, sRGB.
/// Slopes are shaded softly; there are no cast shadows, because the ray tracer computes its own.
[[nodiscard]] SquareRaster<std::uint8_t> paint_orthophoto(const SquareModel& model);

}  // namespace terravox::survey
