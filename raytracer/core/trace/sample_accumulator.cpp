#include "raytracer/core/trace/sample_accumulator.hpp"

#include <algorithm>
#include <numeric>

namespace terravox::trace {

void SampleAccumulator::begin_tile(std::size_t pixels, bool with_layers, std::size_t bands) {
    m_samples.resize(pixels);
    m_layers.resize(with_layers ? pixels : 0);
    m_band_count = bands;
    m_bands.resize(bands * pixels);
}

void SampleAccumulator::begin_part(std::size_t pixels) {
    m_pixel_sums.assign(pixels, {});
    m_layer_sums.assign(m_layers.empty() ? 0 : pixels, {});
    m_part_bands.assign(m_band_count > 0 ? pixels : 0, {});
    m_active.resize(pixels);
    std::iota(m_active.begin(), m_active.end(), 0U);
    m_round = 0;
}

bool SampleAccumulator::add_round(std::span<const shade::SampleSum> samples,
                                  const shade::View& view, std::uint32_t wanted_samples) {
    for (std::size_t i = 0; i < m_active.size(); ++i) {
        m_pixel_sums[m_active[i]].add(samples[i]);
        if (!m_layer_sums.empty())
            m_layer_sums[m_active[i]].add(samples[i], view);
        if (m_band_count > 0)
            m_part_bands[m_active[i]] = samples[i].bands;
    }
    ++m_round;
    const auto& quality = view.scene.quality;
    const auto round = static_cast<int>(m_round);
    constexpr int kCheckPeriod = 4;
    if (quality.noise > 0 && round >= quality.min_samples && round % kCheckPeriod == 0)
        std::erase_if(m_active, [&](std::uint32_t i) {
            return m_pixel_sums[i].mean(view.voxel_m).is_known(quality.noise);
        });
    const int wanted = wanted_samples > 0 ? static_cast<int>(wanted_samples) : quality.samples;
    return round < wanted && !m_active.empty();
}

void SampleAccumulator::end_part(std::span<const TilePixel> pixels, double voxel_m) {
    for (std::size_t i = 0; i < pixels.size(); ++i)
        m_samples[pixels[i].place] = m_pixel_sums[i].mean(voxel_m);
    for (std::size_t i = 0; i < m_layer_sums.size(); ++i)
        m_layers[pixels[i].place] = m_layer_sums[i].mean();
    for (std::size_t i = 0; i < m_part_bands.size(); ++i)
        std::copy_n(m_part_bands[i].begin(), m_band_count,
                    m_bands.begin() + static_cast<std::ptrdiff_t>(pixels[i].place * m_band_count));
}

}  // namespace terravox::trace
