#pragma once

#include <cstdint>
#include <vector>

#include "raytracer/core/output/tile_sink.hpp"
#include "raytracer/core/tiles/tile.hpp"

namespace terravox::output {

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
