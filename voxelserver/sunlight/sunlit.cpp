#include "voxelserver/sunlight/sunlit.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/det_math.hpp"

namespace terravox::sunlight {
namespace {

constexpr double kDegree = det::kPi / 180;

}  // namespace

std::vector<float> horizons(const Scene& scene, double azimuth_deg) {
    const double east = det::sin(azimuth_deg * kDegree);
    const double south = -det::cos(azimuth_deg * kDegree);
    std::vector<float> out(scene.size(), 0.0F);
    // Step by step over all cells: the cells of a row are independent of each other.
    for (int step = 1; step <= scene.margin; ++step) {
        const int dx = static_cast<int>(std::floor(step * east + 0.5));
        const int dz = static_cast<int>(std::floor(step * south + 0.5));
        const auto per_run = static_cast<float>(1 / (step * scene.cell_m));
        for (int z = scene.margin; z < scene.height - scene.margin; ++z) {
            const float* own = &scene.top_m[scene.index(scene.margin, z)];
            const float* there = &scene.top_m[scene.index(scene.margin + dx, z + dz)];
            float* horizon = &out[scene.index(scene.margin, z)];
            const int count = scene.width - 2 * scene.margin;
            for (int x = 0; x < count; ++x)
                horizon[x] = std::max(horizon[x], (there[x] - own[x]) * per_run);
        }
    }
    return out;
}

Sunlit::Sunlit(double altitude_deg) noexcept {
    constexpr double kHalfSoft_deg = 1;
    const double rise = det::tan(altitude_deg * kDegree);
    m_rise = static_cast<float>(rise);
    m_sharpness = static_cast<float>(0.5 / (kHalfSoft_deg * kDegree * (1 + rise * rise)));
}

Facing::Facing(const Sun& sun) noexcept {
    const double rise = det::tan(sun.altitude_deg * kDegree);
    m_east = static_cast<float>(det::sin(sun.azimuth_deg * kDegree) / rise);
    m_south = static_cast<float>(-det::cos(sun.azimuth_deg * kDegree) / rise);
}

float Facing::on(const Slope& slope) const noexcept {
    const float up = 1 / std::sqrt(1 + slope.east * slope.east + slope.south * slope.south);
    return std::max(0.0F, up * (1 - m_east * slope.east - m_south * slope.south));
}

}  // namespace terravox::sunlight
