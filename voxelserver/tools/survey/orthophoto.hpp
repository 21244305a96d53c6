#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "voxelserver/tools/survey/building.hpp"
#include "voxelserver/tools/survey/geotiff.hpp"
#include "voxelserver/tools/survey/land_cover.hpp"
#include "voxelserver/tools/survey/square_model.hpp"

namespace terravox::survey {

/// sRGB, each channel [0, 255], not yet rounded.
struct Colour {
    double r = 0;
    double g = 0;
    double b = 0;
    [[nodiscard]] constexpr Colour operator*(double f) const noexcept {
        return {r * f, g * f, b * f};
    }
    [[nodiscard]] constexpr Colour mixed(Colour other, double part) const noexcept {
        return {lerp(r, other.r, part), lerp(g, other.g, part), lerp(b, other.b, part)};
    }
};

/// Colours of surfaces and objects from above on a summer's day. Functions of seed and place only.
[[nodiscard]] Colour ground_colour(std::uint64_t seed, Cover cover, Vec2 p) noexcept;
/// @param depth_m of the water; shallow water shows its bed
[[nodiscard]] Colour water_colour(std::uint64_t seed, Vec2 p, double depth_m, bool lake) noexcept;
/// @param side the roof face: 0 to the left of the ridge, 1 to the right
[[nodiscard]] Colour roof_colour(const Building& building, int side) noexcept;
[[nodiscard]] Colour crown_colour(const Tree& tree) noexcept;

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
