#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "raytracer/core/trace/ray_wave.hpp"
#include "raytracer/core/trace/tile_pixels.hpp"

namespace terravox::trace {

/// Makes the rays of one sample of each active pixel: in packets for a block whose rays start
/// together, where the machine has the instructions, otherwise one by one. A ray that hits nothing,
/// or whose end a packet has found, does not become pending.
class PrimaryRays {
public:
    /// @param samples of the active pixels; sets their random numbers
    /// @param active indices into `pixels`, ascending
    /// @param counts of the tile
    PrimaryRays(TracerTools& tools, std::span<const TilePixel> pixels,
                std::span<const std::uint32_t> active, std::span<shade::SampleSum> samples,
                RayWave& wave, tiles::TraceCounts& counts) noexcept
        : m_tools(tools),
          m_pixels(pixels),
          m_active(active),
          m_samples(samples),
          m_wave(wave),
          m_counts(counts) {}

    /// @param sample index of the sample, the same for all pixels
    void make(std::uint32_t sample);

private:
    void make_single(std::uint32_t place);
    void make_packet(const PixelBlock& block, std::uint32_t first, std::uint32_t count);
    [[nodiscard]] std::pair<double, double> picture_point(std::uint32_t place) const noexcept;

    TracerTools& m_tools;
    std::span<const TilePixel> m_pixels;
    std::span<const std::uint32_t> m_active;
    std::span<shade::SampleSum> m_samples;
    RayWave& m_wave;
    std::span<walk::TracedRay> m_rays;  ///< of the wave, one for each active pixel
    tiles::TraceCounts& m_counts;
};

}  // namespace terravox::trace
