#include "raytracer/core/trace/sample_accumulator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace terravox::trace {

void BatchMeans::add(float value) noexcept {
    m_sums[m_batches] += value;
    ++m_in_last;
    if (m_in_last < m_batch_size)
        return;
    m_in_last = 0;
    ++m_batches;
    if (m_batches == kMostBatches)
        join_pairs();
}

double BatchMeans::error() const noexcept {
    if (m_batches < 2)
        return 0;
    const auto batches = static_cast<double>(m_batches);
    double mean = 0;
    for (std::size_t i = 0; i < m_batches; ++i)
        mean += static_cast<double>(m_sums[i]);
    mean /= batches;
    double squares = 0;
    for (std::size_t i = 0; i < m_batches; ++i) {
        const double deviation = static_cast<double>(m_sums[i]) - mean;
        squares += deviation * deviation;
    }
    // The variance of one batch's mean stands for as many numbers as the batch has.
    const auto size = static_cast<double>(m_batch_size);
    const double of_batch = squares / (batches - 1) / (size * size);
    const double numbers = batches * size + static_cast<double>(m_in_last);
    return std::sqrt(of_batch * size / numbers);
}

void BatchMeans::join_pairs() noexcept {
    constexpr std::size_t kLeft = kMostBatches / 2;
    for (std::size_t i = 0; i < kLeft; ++i)
        m_sums[i] = m_sums[2 * i] + m_sums[2 * i + 1];
    for (std::size_t i = kLeft; i < kMostBatches; ++i)
        m_sums[i] = 0;
    m_batches = kLeft;
    m_batch_size *= 2;
}

namespace {

void add_to(double (&sum)[3], voxel::Colour c) noexcept {
    sum[0] += static_cast<double>(c.r);
    sum[1] += static_cast<double>(c.g);
    sum[2] += static_cast<double>(c.b);
}
void add_to(double (&sum)[3], core::Vec3 v) noexcept {
    sum[0] += v.x;
    sum[1] += v.y;
    sum[2] += v.z;
}
voxel::Colour to_colour(const double (&sum)[3], double n) noexcept {
    return {static_cast<float>(sum[0] / n), static_cast<float>(sum[1] / n),
            static_cast<float>(sum[2] / n)};
}
std::array<float, 3> to_vector(const double (&sum)[3], double n) noexcept {
    return {static_cast<float>(sum[0] / n), static_cast<float>(sum[1] / n),
            static_cast<float>(sum[2] / n)};
}

}  // namespace

void PixelSum::add(const shade::SampleSum& sample) noexcept {
    const voxel::Colour c = sample.direct + sample.indirect;
    add_to(m_colour, c);
    m_brightness.add(voxel::luminance(c));
    ++m_count;
    if (sample.t < core::kFar) {
        m_t += sample.t;
        ++m_hits;
    }
}

tiles::PixelSample PixelSum::mean(double voxel_m) const noexcept {
    tiles::PixelSample out;
    out.colour = to_colour(m_colour, m_count);
    out.alpha = static_cast<float>(static_cast<double>(m_hits) / m_count);
    out.depth_m = m_hits > 0 ? static_cast<float>(m_t / m_hits * voxel_m)
                             : std::numeric_limits<float>::infinity();
    out.samples = static_cast<std::uint32_t>(m_count);
    out.error = static_cast<float>(m_brightness.error());
    return out;
}

void LayerSum::add(const shade::SampleSum& sample, const shade::View& view) noexcept {
    add_to(m_direct, sample.direct);
    add_to(m_indirect, sample.indirect);
    ++m_count;
    if (!(sample.t < core::kFar))
        return;
    if (m_hits++ == 0)
        m_material = sample.material;
    add_to(m_albedo, sample.albedo);
    add_to(m_normal, sample.normal);
    add_to(m_position, (sample.point - view.origin) * view.voxel_m);
    m_sun += static_cast<double>(sample.sun);
    m_water += sample.water ? 1 : 0;
    m_materials.add(static_cast<std::uint32_t>(sample.material), 1);
    m_squares.add(view.squares.compute_index(sample.point.x, sample.point.z), 1);
}

tiles::LayerSample LayerSum::mean() const noexcept {
    tiles::LayerSample out;
    out.direct = to_colour(m_direct, m_count);
    out.indirect = to_colour(m_indirect, m_count);
    out.material = m_material;
    out.materials = m_materials;
    out.squares = m_squares;
    out.materials.scale(1.0f / static_cast<float>(m_count));
    out.squares.scale(1.0f / static_cast<float>(m_count));
    if (m_hits == 0)
        return out;
    out.albedo = to_colour(m_albedo, m_hits);
    out.normal = to_vector(m_normal, m_hits);
    out.position = to_vector(m_position, m_hits);
    out.sun = static_cast<float>(m_sun / m_hits);
    out.water = static_cast<float>(static_cast<double>(m_water) / m_hits);
    return out;
}

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
