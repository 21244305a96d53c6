#include "raytracer/core/sky/ambient.hpp"

#include <algorithm>
#include <cmath>

namespace terravox::sky {
namespace {

constexpr int kNodes = 25;  // along an edge; odd, so that all six axes are nodes

core::Vec3 normal_at(int i, int j) noexcept {
    const double u = 2.0 * i / (kNodes - 1) - 1;
    const double v = 2.0 * j / (kNodes - 1) - 1;
    const double y = 1 - std::fabs(u) - std::fabs(v);
    if (y >= 0)
        return core::normalized({u, y, v});
    return core::normalized(
        {(1 - std::fabs(v)) * (u >= 0 ? 1 : -1), y, (1 - std::fabs(u)) * (v >= 0 ? 1 : -1)});
}

}  // namespace

AmbientTable::AmbientTable(std::span<const LightFrom> light) {
    m_nodes.reserve(kNodes * kNodes);
    for (int j = 0; j < kNodes; ++j)
        for (int i = 0; i < kNodes; ++i) {
            const core::Vec3 n = normal_at(i, j);
            double r = 0;
            double g = 0;
            double b = 0;
            for (const LightFrom& from : light) {
                const double w = std::max(0.0, core::dot(n, from.direction)) * from.solid_angle;
                r += w * static_cast<double>(from.radiance.r);
                g += w * static_cast<double>(from.radiance.g);
                b += w * static_cast<double>(from.radiance.b);
            }
            m_nodes.push_back({static_cast<float>(r / det::kPi), static_cast<float>(g / det::kPi),
                               static_cast<float>(b / det::kPi)});
        }
}

voxel::Colour AmbientTable::at(core::Vec3 n) const noexcept {
    const double sum = std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z);
    if (m_nodes.empty() || !(sum > 0 && sum < 1e300))
        return {};
    double u = n.x / sum;
    double v = n.z / sum;
    if (n.y < 0) {
        const double folded = (1 - std::fabs(v)) * (u >= 0 ? 1 : -1);
        v = (1 - std::fabs(u)) * (v >= 0 ? 1 : -1);
        u = folded;
    }
    u = (u + 1) / 2 * (kNodes - 1);
    v = (v + 1) / 2 * (kNodes - 1);
    const int i = std::clamp(static_cast<int>(u), 0, kNodes - 2);
    const int j = std::clamp(static_cast<int>(v), 0, kNodes - 2);
    const voxel::Colour* node = &m_nodes[static_cast<std::size_t>(j * kNodes + i)];
    const auto a = static_cast<float>(u - i);
    const auto b = static_cast<float>(v - j);
    return voxel::mix(voxel::mix(node[0], node[1], a),
                      voxel::mix(node[kNodes], node[kNodes + 1], a), b);
}

}  // namespace terravox::sky
