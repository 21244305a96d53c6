#include "raytracer/analyse/solar/far_horizon.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/det_math.hpp"

namespace terravox::solar {
namespace {

constexpr int kBoundsPerSlope = 16;
constexpr int kBounds = 256;  // slopes up to 16: 86 degrees

/// Two neighbours, and how far from the first one to the second a place is.
struct Between {
    int first = 0;
    int second = 0;
    double share = 0;
};

/// @param at place along points of which the first and the last are at `from` and `to`
Between among_points(double at, double from, double to, int count) noexcept {
    if (count < 2 || !(to > from))
        return {};
    const double place = std::clamp((at - from) / (to - from), 0.0, 1.0) * (count - 1);
    const int first = static_cast<int>(place);
    return {first, std::min(first + 1, count - 1), place - first};
}

Between around_circle(double azimuth_deg) noexcept {
    constexpr double kPerDegree = FarHorizon::kAzimuths / 360.0;
    const double place = std::clamp(azimuth_deg, 0.0, 360.0) * kPerDegree;
    const int first = static_cast<int>(place);
    return {first % FarHorizon::kAzimuths, (first + 1) % FarHorizon::kAzimuths, place - first};
}

double mix(double a, double b, double share) noexcept {
    return a + (b - a) * share;
}

double shadow_height_of(const FarTop& top, double slope) noexcept {
    return top.height_m - slope * top.distance_m;
}

double along(double from, double to, int place, int count) noexcept {
    return count > 1 ? from + (to - from) * place / (count - 1) : (from + to) / 2;
}

}  // namespace

std::size_t FarHorizon::Lattice::points() const noexcept {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
}
double FarHorizon::Lattice::x(int column) const noexcept {
    return along(west, east, column, columns);
}
double FarHorizon::Lattice::z(int row) const noexcept {
    return along(north, south, row, rows);
}

FarHorizon::FarHorizon(const Lattice& lattice, const std::vector<Tops>& tops, double voxel_m)
    : m_lattice(lattice), m_voxel_m(voxel_m), m_bounds(kBounds, kLowest_m) {
    m_begins.reserve(tops.size() + 1);
    for (const Tops& some : tops) {
        m_begins.push_back(static_cast<std::uint32_t>(m_tops.size()));
        m_tops.insert(m_tops.end(), some.begin(), some.end());
    }
    m_begins.push_back(static_cast<std::uint32_t>(m_tops.size()));
    for (int i = 0; i < kBounds; ++i)
        for (const FarTop& top : m_tops) {
            double& bound = m_bounds[static_cast<std::size_t>(i)];
            bound =
                std::max(bound, shadow_height_of(top, static_cast<double>(i) / kBoundsPerSlope));
        }
}

double FarHorizon::shadow_height(std::size_t point, int azimuth, double slope) const noexcept {
    const std::size_t index = point * kAzimuths + static_cast<std::size_t>(azimuth);
    double out = kLowest_m;
    for (std::uint32_t i = m_begins[index]; i < m_begins[index + 1]; ++i)
        out = std::max(out, shadow_height_of(m_tops[i], slope));
    return out;
}

double FarHorizon::shadow_height(core::Vec3 from, double azimuth_deg, double slope) const noexcept {
    const Between x = among_points(from.x, m_lattice.west, m_lattice.east, m_lattice.columns);
    const Between z = among_points(from.z, m_lattice.north, m_lattice.south, m_lattice.rows);
    const Between around = around_circle(azimuth_deg);
    const auto at = [&](int column, int row) {
        const auto point = static_cast<std::size_t>(row * m_lattice.columns + column);
        return mix(shadow_height(point, around.first, slope),
                   shadow_height(point, around.second, slope), around.share);
    };
    const auto along_x = [&](int row) { return mix(at(x.first, row), at(x.second, row), x.share); };
    return mix(along_x(z.first), along_x(z.second), z.share);
}

bool FarHorizon::hides(core::Vec3 from, core::Vec3 to) const noexcept {
    const double level = std::sqrt(to.x * to.x + to.z * to.z);
    if (empty() || !(level > 0))
        return false;
    const double slope = to.y / level;
    const double height_m = from.y * m_voxel_m;
    const double bound = std::clamp(slope * kBoundsPerSlope, 0.0, kBounds - 1.0);
    if (height_m >= m_bounds[static_cast<std::size_t>(bound)])
        return false;
    constexpr double kDegPerRad = 180 / det::kPi;
    const double azimuth_deg = det::atan2(to.x, -to.z) * kDegPerRad;
    return height_m < shadow_height(from, azimuth_deg < 0 ? azimuth_deg + 360 : azimuth_deg, slope);
}

}  // namespace terravox::solar
