#include "raytracer/analyse/evaluators/sight_line.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "raytracer/analyse/evaluators/column_descent.hpp"

namespace terravox::analyse {
namespace {

// The mean radius of the Earth (IUGG).
constexpr double kEarth_m = 6371008.8;
// Far more than any horizon needs; it only bounds what a scene can ask for.
constexpr double kMaxChords = 65536;

bool comes_first(core::Vec3 a, core::Vec3 b) noexcept {
    if (a.x != b.x)
        return a.x < b.x;
    return a.z != b.z ? a.z < b.z : a.y < b.y;
}

}  // namespace

core::Vec3 on_sight_grid(core::Vec3 p) noexcept {
    return {on_grid(p.x), on_grid(p.y), on_grid(p.z)};
}

double horizontal_distance2(core::Vec3 a, core::Vec3 b) noexcept {
    const core::Vec3 d = b - a;
    return d.x * d.x + d.z * d.z;
}

// A height at the distance s from the end of a line of length d lies (1 - k) s (d - s) / 2R above
// the straight line between its ends, seen from the curved surface that heights are measured from;
// so in the world's coordinates the line lies as much below. Ref: Baeyer, "Küstenvermessung", 1849
// (the coefficient k of refraction as a ratio of radii).
double sag_of_sight(double voxel_m, double refraction) noexcept {
    return (1 - refraction) * voxel_m / (2 * kEarth_m);
}

SightLine::SightLine(core::Vec3 one, core::Vec3 other, double sag) noexcept
    : m_from(one), m_to(other) {
    if (comes_first(m_to, m_from))
        std::swap(m_from, m_to);
    const double distance2 = horizontal_distance2(m_from, m_to);
    m_sag_voxels = sag * distance2;
    // A chord of a parabola lies farthest off it in its middle: by a quarter of sag times its
    // length squared.
    const double wanted = std::ceil(std::sqrt(m_sag_voxels / (4 * kMaxError_voxels)));
    m_chords = static_cast<std::uint32_t>(std::clamp(wanted, 1.0, kMaxChords));
}

core::Vec3 SightLine::joint(std::uint32_t i) const noexcept {
    if (i == 0)
        return m_from;
    if (i >= m_chords)
        return m_to;
    const double share = static_cast<double>(i) / m_chords;
    core::Vec3 out = m_from + (m_to - m_from) * share;
    out.y -= m_sag_voxels * share * (1 - share);
    return out;
}

}  // namespace terravox::analyse
