#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "raytracer/core/trace/pixel_sum.hpp"
#include "raytracer/core/trace/tile_pixels.hpp"

namespace terravox::trace {

/// Sums up the samples of a tile's pixels, part by part and round by round: each round has one
/// sample of every pixel that is still active, that is, needs more samples.
class SampleAccumulator {
public:
    /// @param pixels of the tile
    /// @param bands measured values of each pixel, which has a single sample then; 0: a picture
    void begin_tile(std::size_t pixels, bool with_layers, std::size_t bands = 0);
    /// @param pixels of the part; all of them become active
    void begin_part(std::size_t pixels);
    /// Indices of the active pixels of the part, ascending.
    [[nodiscard]] std::span<const std::uint32_t> active() const noexcept { return m_active; }
    /// Number of samples that the active pixels have.
    [[nodiscard]] std::uint32_t round() const noexcept { return m_round; }
    /// @param samples one for each active pixel, in their order
    /// @param wanted_samples of a pixel; 0: as many as the view's scene specifies
    /// @return whether any pixels are still active
    [[nodiscard]] bool add_round(std::span<const shade::SampleSum> samples, const shade::View& view,
                                 std::uint32_t wanted_samples);
    /// Stores the means of the part in the tile.
    /// @param pixels of the part
    /// @param voxel_m edge of a level-0 voxel
    void end_part(std::span<const TilePixel> pixels, double voxel_m);
    /// Of the tile, by TilePixel::place.
    [[nodiscard]] std::vector<tiles::PixelSample> take_samples() { return std::move(m_samples); }
    /// Of the tile, by TilePixel::place; empty without layers.
    [[nodiscard]] std::vector<tiles::LayerSample> take_layers() { return std::move(m_layers); }
    /// Of the tile, by TilePixel::place, pixel by pixel; empty for pictures.
    [[nodiscard]] std::vector<float> take_bands() { return std::move(m_bands); }

private:
    std::vector<tiles::PixelSample> m_samples;
    std::vector<tiles::LayerSample> m_layers;
    std::vector<float> m_bands;
    std::vector<core::Bands> m_part_bands;  ///< of the part's pixels; empty for pictures
    std::size_t m_band_count = 0;
    std::vector<PixelSum> m_pixel_sums;
    std::vector<LayerSum> m_layer_sums;  ///< empty without layers
    std::vector<std::uint32_t> m_active;
    std::uint32_t m_round = 0;
};

}  // namespace terravox::trace
