#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "raytracer/core/base/scene_words.hpp"
#include "raytracer/core/tiles/tile.hpp"

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
    /// World: metres from Camera::picture_origin(), x east, y up, z south. EXR's worldToCamera (the
    /// camera looks along -z, y is up) and worldToNDC ((0, 0) is the upper left corner, (1, 1) the
    /// lower right one).
    std::optional<std::array<float, 16>> world_to_camera;
    std::optional<std::array<float, 16>> world_to_ndc;
    bool layers = true;  ///< EXR: write the film's layers, where it has any
    /// By the SquareGrid's index; squares beyond the end are all named "unknown".
    std::vector<std::string> square_names;

    std::optional<GeoPlacement> geo;  ///< makes a .tif a GeoTIFF (image_writer.hpp)
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
/// visible escapes (common/util/text.hpp).
[[nodiscard]] PictureInfo with_clean_texts(PictureInfo info);

/// Destination of finished tiles: a Film, or a file (TileStream).
class TileSink {
public:
    TileSink() = default;
    TileSink(const TileSink&) = default;
    TileSink& operator=(const TileSink&) = default;
    virtual ~TileSink() = default;
    /// Not thread-safe.
    /// @throws Error
    virtual void add(const tiles::TileResult& result) = 0;
    /// Whether a tile that is added again replaces the earlier one.
    [[nodiscard]] virtual bool replaces() const noexcept { return false; }
};

/// The picture while it is being rendered: linear light and depth, row by row from the top left. A
/// coarse sample fills its whole block of pixels until finer passes replace it. Not thread-safe.
class Film final : public TileSink {
public:
    Film(int width_px, int height_px, bool with_layers = false);

    /// Passes must be added in order, tiles of a pass in any order. Later samples of the same
    /// pixels are averaged with the earlier ones.
    void add(const tiles::TileResult& result) override;
    /// As long as it has no more than the first samples.
    [[nodiscard]] bool replaces() const noexcept override { return true; }

    /// Memory that a film of that size takes.
    [[nodiscard]] static std::uint64_t bytes(int width_px, int height_px,
                                             bool with_layers) noexcept {
        return static_cast<std::uint64_t>(width_px) * static_cast<std::uint64_t>(height_px) *
               (sizeof(tiles::PixelSample) + (with_layers ? sizeof(tiles::LayerSample) : 0));
    }

    /// Whether a pixel of the tile is not known that precisely yet: see PixelSample::is_known.
    [[nodiscard]] bool error_above(const tiles::RenderTile& tile, double share) const noexcept;
    [[nodiscard]] int width_px() const noexcept { return m_width; }
    [[nodiscard]] int height_px() const noexcept { return m_height; }
    [[nodiscard]] const tiles::PixelSample& at(int x, int y) const noexcept {
        return m_pixels[index(x, y)];
    }
    /// All samples, row by row.
    [[nodiscard]] const std::vector<tiles::PixelSample>& samples() const noexcept {
        return m_pixels;
    }
    /// Sets the colour and nothing else, for filters over the whole picture.
    void set_colour(int x, int y, voxel::Colour colour) noexcept {
        m_pixels[index(x, y)].colour = colour;
    }
    [[nodiscard]] bool has_layers() const noexcept { return !m_layers.empty(); }
    [[nodiscard]] const tiles::LayerSample& layers_at(int x, int y) const noexcept {
        return m_layers[index(x, y)];
    }

private:
    [[nodiscard]] std::size_t index(int x, int y) const noexcept {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(m_width) +
               static_cast<std::size_t>(x);
    }
    int m_width;
    int m_height;
    std::vector<tiles::PixelSample> m_pixels;
    std::vector<tiles::LayerSample> m_layers;
};

}  // namespace terravox::output
