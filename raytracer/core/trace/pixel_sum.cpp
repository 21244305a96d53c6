#include "raytracer/core/trace/pixel_sum.hpp"

#include <limits>

namespace terravox::trace {
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
voxel::Colour colour_of(const double (&sum)[3], double n) noexcept {
    return {static_cast<float>(sum[0] / n), static_cast<float>(sum[1] / n),
            static_cast<float>(sum[2] / n)};
}
std::array<float, 3> vector_of(const double (&sum)[3], double n) noexcept {
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
    out.colour = colour_of(m_colour, m_count);
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
    m_squares.add(view.squares.index_of(sample.point.x, sample.point.z), 1);
}

tiles::LayerSample LayerSum::mean() const noexcept {
    tiles::LayerSample out;
    out.direct = colour_of(m_direct, m_count);
    out.indirect = colour_of(m_indirect, m_count);
    out.material = m_material;
    out.materials = m_materials;
    out.squares = m_squares;
    out.materials.scale(1.0f / static_cast<float>(m_count));
    out.squares.scale(1.0f / static_cast<float>(m_count));
    if (m_hits == 0)
        return out;
    out.albedo = colour_of(m_albedo, m_hits);
    out.normal = vector_of(m_normal, m_hits);
    out.position = vector_of(m_position, m_hits);
    out.sun = static_cast<float>(m_sun / m_hits);
    out.water = static_cast<float>(static_cast<double>(m_water) / m_hits);
    return out;
}

}  // namespace terravox::trace
