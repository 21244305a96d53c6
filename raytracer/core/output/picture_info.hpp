#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "raytracer/core/base/scene_words.hpp"

namespace terravox::output {

/// Text stored in the picture: name and value, both UTF-8. "Software", "Copyright" and
/// "ImageDescription" are stored where each format has a dedicated place for them.
using ImageMetadata = std::vector<std::pair<std::string, std::string>>;

/// Position on Earth of a picture that looks straight down.
struct GeoPlacement {
    /// In GDAL's order: x = t[0] + column * t[1] + row * t[2], y = t[3] + column * t[4] + row *
    /// t[5], in units of the CRS, of a pixel's upper left corner.
    std::array<double, 6> transform{};
    std::string crs_wkt;
};

/// Everything that is stored in a picture in addition to its light, and how its light becomes
/// display values. Filled by the renderer.
struct PictureInfo {
    double exposure_ev = 0;                                 ///< of 8-bit pictures, stops
    core::ToneCurve tone = core::ToneCurve::kPhotographic;  ///< of 8-bit pictures
    std::string credit;      ///< line at the lower right of 8-bit pictures, UTF-8; empty: none
    ImageMetadata metadata;  ///< JPEG stores only the three names above

    /// Row-major, for row vectors (v * M, as in OpenEXR: the translation is in the last row).
    /// World: metres from PictureFrame's origin, x east, y up, z south. EXR's worldToCamera (the
    /// camera looks along -z, y is up) and worldToNDC ((0, 0) is the upper left corner, (1, 1) the
    /// lower right one).
    std::optional<std::array<float, 16>> world_to_camera;
    std::optional<std::array<float, 16>> world_to_ndc;
    bool layers = true;  ///< EXR: write the film's layers, where it has any
    /// By the SquareGrid's index; squares beyond the end are all named "unknown".
    std::vector<std::string> square_names;

    std::optional<GeoPlacement> geo;  ///< makes a .tif a GeoTIFF (tiff_picture.hpp)
    /// Of .tif. kAuto: 8-bit for a GeoTIFF, which is used as a map layer, and linear 32-bit float
    /// for any other.
    core::TiffSamples tiff_samples = core::TiffSamples::kAuto;
    [[nodiscard]] bool tiff_holds_floats() const noexcept {
        return tiff_samples == core::TiffSamples::kFloat ||
               (tiff_samples == core::TiffSamples::kAuto && !geo);
    }
};

/// Makes the metadata texts that every format can hold: titles and attributions come from data of
/// strangers. Bytes that are not UTF-8, and control characters other than line feed and tab, become
/// visible escapes (common/util/printable.hpp).
[[nodiscard]] PictureInfo with_clean_texts(PictureInfo info);

}  // namespace terravox::output
