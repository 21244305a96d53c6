#pragma once

#include <cstdint>
#include <optional>

#include "voxelserver/tools/survey/geotiff.hpp"
#include "voxelserver/tools/survey/square_model.hpp"

namespace terravox::survey {

/// The light under which an orthophoto is taken.
struct PhotoLight {
    double azimuth_deg = 180;  ///< of the sun, clockwise from grid north, [0, 360)
    double altitude_deg = 45;  ///< of the sun, [10, 85]
    double haze = 0;           ///< [0, 1]: more light from the sky, less contrast, a veil
    double clouds = 0;         ///< [0, 1]: how much of the sun the shadows of clouds take away
};

/// An orthophoto and what it would look like without light.
struct LitPhoto {
    SquareRaster<std::uint8_t> photo;   ///< sRGB, three bands
    SquareRaster<std::uint8_t> albedo;  ///< the same
};

/// Light from the sun with cast shadows, from the sky and, with haze, from the air between; the
/// exposure is such that a flat, sunlit surface has its own colour. What stands more than
/// kShadowReach_m away casts no shadow. A function of place and light only.
[[nodiscard]] LitPhoto take_photo(const SquareModel& model, const PhotoLight& light);

inline constexpr double kShadowReach_m = 60;

}  // namespace terravox::survey
