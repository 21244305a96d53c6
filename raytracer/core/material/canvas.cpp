#include "raytracer/core/material/canvas.hpp"

#include <cmath>

#include "raytracer/core/base/random.hpp"

namespace terravox::material {
namespace {

float smooth(float t) noexcept {
    return t * t * (3 - 2 * t);
}

// The shorter way round the canvas.
float around(float d) noexcept {
    constexpr float kEdge = kTexels;
    return d > kEdge / 2 ? d - kEdge : d < -kEdge / 2 ? d + kEdge : d;
}

}  // namespace

float chance(int a, int b, std::uint64_t seed) noexcept {
    return static_cast<float>(core::unit_from(core::hash64(
        static_cast<std::uint32_t>(a) | static_cast<std::uint64_t>(static_cast<std::uint32_t>(b))
                                            << 32,
        seed)));
}

float grain(int s, int t, std::uint64_t seed) noexcept {
    return 2 * chance(s & (kTexels - 1), t & (kTexels - 1), seed) - 1;
}

float cloud(int s, int t, int cells, std::uint64_t seed) noexcept {
    const int size = kTexels / cells;
    s &= kTexels - 1;
    t &= kTexels - 1;
    const int i = s / size;
    const int j = t / size;
    const auto corner = [&](int di, int dj) {
        return 2 * chance((i + di) % cells, (j + dj) % cells, seed) - 1;
    };
    const auto within = [&](int v) {
        return smooth((static_cast<float>(v % size) + 0.5f) / static_cast<float>(size));
    };
    const float x = within(s);
    const float y = within(t);
    const float low = corner(0, 0) * (1 - x) + corner(1, 0) * x;
    const float high = corner(0, 1) * (1 - x) + corner(1, 1) * x;
    return low * (1 - y) + high * y;
}

float wave(float turns) noexcept {
    const float x = turns - std::floor(turns + 0.5f);  // [-1/2, 1/2)
    const float a = 4 * (std::fabs(x) - 0.25f);        // [-1, 1], -1 at whole turns
    return -a * (2 - std::fabs(a));
}

voxel::Colour tint(float brightness, float warm) noexcept {
    return {brightness * (1 + 0.5f * warm), brightness * (1 + 0.12f * warm),
            brightness * (1 - 0.7f * warm)};
}

Stones::Stones(int per_edge, std::uint64_t seed) {
    const float size = static_cast<float>(kTexels) / static_cast<float>(per_edge);
    for (int j = 0; j < per_edge; ++j)
        for (int i = 0; i < per_edge; ++i)
            m_points.push_back(
                {(static_cast<float>(i) + 0.1f + 0.8f * chance(i, j, seed)) * size,
                 (static_cast<float>(j) + 0.1f + 0.8f * chance(i, j, seed + 1)) * size});
}

Stones::At Stones::at(int s, int t) const noexcept {
    float nearest = 1e9f;
    float second = 1e9f;
    At out;
    for (std::size_t i = 0; i < m_points.size(); ++i) {
        const float ds = around(static_cast<float>(s) + 0.5f - m_points[i][0]);
        const float dt = around(static_cast<float>(t) + 0.5f - m_points[i][1]);
        const float far = std::sqrt(ds * ds + dt * dt);
        if (far < nearest) {
            second = nearest;
            nearest = far;
            out.id = static_cast<int>(i);
            out.up = dt;
        } else if (far < second)
            second = far;
    }
    out.edge = (second - nearest) / 2;
    return out;
}

}  // namespace terravox::material
