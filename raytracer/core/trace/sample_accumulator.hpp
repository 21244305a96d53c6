#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "raytracer/core/shade/shading.hpp"
#include "raytracer/core/tiles/tile.hpp"
#include "raytracer/core/trace/tile_pixels.hpp"

namespace terravox::trace {

/// The standard error of the mean of a sequence whose neighbours are spread evenly, as those of a
/// scrambled (0,2)-sequence are: means of batches of 2^k successive numbers vary less than as many
/// independent numbers would. 8 to 15 batches are compared, so they grow with the sequence.
/// Ref: Yeh and Schmeiser, "Simulation output analysis via dynamic batch means", WSC 2000.
///
/// The mean of all batches is nearer to the truth than independent ones would be, too, so the error
/// is rather too large than too small.
class BatchMeans {
public:
    void add(float value) noexcept;
    /// Standard error of the mean of all numbers so far; 0 with fewer than two.
    [[nodiscard]] double error() const noexcept;

private:
    static constexpr std::size_t kMostBatches = 16;
    void join_pairs() noexcept;

    std::array<float, kMostBatches> m_sums{};  ///< of batches; the last one may be incomplete
    std::size_t m_batches = 0;                 ///< complete ones
    std::size_t m_batch_size = 1;
    std::size_t m_in_last = 0;  ///< numbers in the incomplete batch
};

/// The sum of a pixel's samples.
class PixelSum {
public:
    void add(const shade::SampleSum& sample) noexcept;
    [[nodiscard]] int count() const noexcept { return m_count; }
    /// Mean of at least one sample.
    /// @param voxel_m edge of a level-0 voxel
    [[nodiscard]] tiles::PixelSample mean(double voxel_m) const noexcept;

private:
    double m_colour[3] = {}, m_t = 0;
    BatchMeans m_brightness;
    int m_count = 0;
    int m_hits = 0;
};

/// The sum of the first hits of a pixel's samples.
class LayerSum {
public:
    void add(const shade::SampleSum& sample, const shade::View& view) noexcept;
    [[nodiscard]] tiles::LayerSample mean() const noexcept;

private:
    double m_direct[3] = {}, m_indirect[3] = {}, m_albedo[3] = {}, m_normal[3] = {},
           m_position[3] = {};
    double m_sun = 0;
    int m_count = 0;
    int m_hits = 0;
    int m_water = 0;
    voxel::Material m_material = voxel::Material::kAir;
    tiles::Matte m_materials;
    tiles::Matte m_squares;
};

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
