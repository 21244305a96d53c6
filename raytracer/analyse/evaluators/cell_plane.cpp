#include "raytracer/analyse/evaluators/cell_plane.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/det_math.hpp"

namespace terravox::analyse {

void HeightSums::add(int east, int south, float height) noexcept {
    const auto x = static_cast<float>(east);
    const auto y = static_cast<float>(south);
    count += 1;
    e += x;
    s += y;
    h += height;
    ee += x * x;
    es += x * y;
    ss += y * y;
    eh += x * height;
    sh += y * height;
    hh += height * height;
}

bool is_same_surface(double distance, double height, double step) noexcept {
    constexpr double kSteepest = 1.5;
    return std::abs(height) <= kSteepest * distance + step;
}

core::Vec3 CellPlane::normal() const noexcept {
    return core::normalized({-east, 1, -south});
}

double azimuth_deg(core::Vec3 normal) noexcept {
    constexpr double kDegPerRad = 180 / det::kPi;
    const double azimuth = det::atan2(normal.x, 0 - normal.z) * kDegPerRad;
    return azimuth < 0 ? azimuth + 360 : azimuth;
}

CellPlane plane_through(const HeightSums& sums, double spacing, double step) noexcept {
    const auto n = static_cast<double>(sums.count);
    const auto product = [n](float of_both, float a, float b) {
        return n * static_cast<double>(of_both) - static_cast<double>(a) * static_cast<double>(b);
    };
    const double ee = product(sums.ee, sums.e, sums.e);
    const double es = product(sums.es, sums.e, sums.s);
    const double ss = product(sums.ss, sums.s, sums.s);
    const double eh = product(sums.eh, sums.e, sums.h);
    const double sh = product(sums.sh, sums.s, sums.h);
    const double hh = product(sums.hh, sums.h, sums.h);
    const double det = ee * ss - es * es;
    if (det <= 0)
        return {};
    // Per step of a cell.
    const double east = (eh * ss - sh * es) / det;
    const double south = (sh * ee - eh * es) / det;
    const double at_cell = (static_cast<double>(sums.h) - east * static_cast<double>(sums.e) -
                            south * static_cast<double>(sums.s)) /
                           n;
    const double residual = std::sqrt(std::max(hh - east * eh - south * sh, 0.0)) / n;
    CellPlane out;
    out.east = east / spacing;
    out.south = south / spacing;
    // Voxels reach above the plane by half of their edge times its slope, and by what rounding of
    // heights to voxels makes of it.
    constexpr double kDeviations = 1.75;
    out.lift = std::max(at_cell, 0.0) + 0.5 * step * (std::abs(out.east) + std::abs(out.south)) +
               kDeviations * residual;
    return out;
}

}  // namespace terravox::analyse
