#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/tools/survey/geotiff.hpp"
#include "voxelserver/tools/survey/square_model.hpp"

namespace terravox::survey {

inline constexpr double kOrthophotoPixel_m = 0.5;

/// Which light the colours of a painting contain.
enum class Shading : std::uint8_t {
    kSoft,  ///< slopes and crowns are shaded a little, as under a high, veiled sun
    kNone,  ///< none: they are the albedo
};

/// The square and a margin around it from straight above (a true orthophoto: no objects lean), with
/// the heights and slopes of what is seen. Pixels row by row, north row first.
struct Painting {
    /// Rise over run, eastwards and northwards.
    struct Slope {
        float east = 0;
        float north = 0;
    };
    int side_px = 0;
    std::vector<std::uint8_t> rgb;  ///< sRGB, three values a pixel
    std::vector<float> top_m;       ///< above sea level
    std::vector<Slope> slope;       ///< empty with Shading::kSoft
};

/// @param margin_m a multiple of kOrthophotoPixel_m, less than kModelMargin_m - 1
[[nodiscard]] Painting paint(const SquareModel& model, Shading shading, double margin_m);

/// The orthophoto without cast shadows, because the ray tracer computes its own: three bands, sRGB.
[[nodiscard]] SquareRaster<std::uint8_t> paint_orthophoto(const SquareModel& model);

}  // namespace terravox::survey
