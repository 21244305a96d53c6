#include "raytracer/core/sky/sky_table.hpp"

#include <algorithm>
#include <cmath>

namespace terravox::sky {
namespace {

// Rows stand at elevations of sine (i / last)^2, close together near the horizon; columns at
// azimuths whose half has the sine j / last, close together near the sun.
constexpr int kRows = 40;
constexpr int kColumns = 24;

/// Clamps to [0, 1]; NaN becomes 0, so that no direction leads outside the table.
double cut(double v) noexcept {
    return v > 0 ? std::min(v, 1.0) : 0;
}

}  // namespace

voxel::Colour sun_colour(const Spectrum& share, double scale) noexcept {
    Spectrum light;
    for (std::size_t k = 0; k < kBands; ++k)
        light[k] = share[k] * kSolarIrradiance[k] * scale;
    return to_rec709(light);
}

double picture_scale() {
    static const double scale = [] {
        constexpr double kNoonLight = 2.4;
        constexpr double kTurbidity = 2.5;
        constexpr double kRad = det::kPi / 180;
        return kNoonLight / static_cast<double>(voxel::luminance(sun_colour(
                                Atmosphere(kTurbidity).transmittance(0, det::sin(45 * kRad)), 1)));
    }();
    return scale;
}

SkyTable::SkyTable(const Scattering& scattering, double height_m, double scale) {
    m_nodes.reserve(static_cast<std::size_t>(kRows) * kColumns);
    for (int i = 0; i < kRows; ++i)
        for (int j = 0; j < kColumns; ++j) {
            if (i == kRows - 1 && j > 0) {  // the zenith is one place
                m_nodes.push_back(m_nodes.back());
                continue;
            }
            const double u = static_cast<double>(i) / (kRows - 1);
            const double v = static_cast<double>(j) / (kColumns - 1);
            const Scattered s = scattering.seen(height_m, u * u, 1 - 2 * v * v);
            m_nodes.push_back({sun_colour(s.rayleigh, scale), sun_colour(s.mie, scale),
                               sun_colour(s.multiple, scale)});
        }
}

voxel::Colour SkyTable::at(double elevation, double azimuth_cosine,
                           double sun_cosine) const noexcept {
    const double u = std::sqrt(cut(elevation)) * (kRows - 1);
    const double v = std::sqrt(cut((1 - azimuth_cosine) / 2)) * (kColumns - 1);
    const int i = std::min(static_cast<int>(u), kRows - 2);
    const int j = std::min(static_cast<int>(v), kColumns - 2);
    const auto a = static_cast<float>(u - i);
    const auto b = static_cast<float>(v - j);
    const auto rayleigh = static_cast<float>(rayleigh_phase(sun_cosine));
    const auto mie = static_cast<float>(mie_phase(sun_cosine));
    const auto of = [&](const Node& n) { return n.rayleigh * rayleigh + n.mie * mie + n.multiple; };
    const Node* node = &m_nodes[static_cast<std::size_t>(i * kColumns + j)];
    return voxel::mix(voxel::mix(of(node[0]), of(node[1]), b),
                      voxel::mix(of(node[kColumns]), of(node[kColumns + 1]), b), a);
}

}  // namespace terravox::sky
