#include "voxelserver/data/imagery/pixel_map.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/error.hpp"

namespace terravox::imagery {
namespace {

// Segments per edge, when an image's outline is transformed to another CRS.
constexpr int kEdgeParts = 16;

/// The outline of an image in the coordinates of its CRS.
void outline(const Image& image, std::vector<double>& x, std::vector<double>& y) {
    const auto& g = image.geo();
    for (int i = 0; i <= kEdgeParts; ++i)
        for (int j = 0; j <= kEdgeParts; ++j) {
            if (i != 0 && i != kEdgeParts && j != 0 && j != kEdgeParts)
                continue;
            const double u = image.width() * static_cast<double>(i) / kEdgeParts;
            const double v = image.height() * static_cast<double>(j) / kEdgeParts;
            x.push_back(g[0] + u * g[1] + v * g[2]);
            y.push_back(g[3] + u * g[4] + v * g[5]);
        }
}

/// As std::llround, without a call of the library for each column.
std::int64_t rounded(double value) noexcept {
    const auto cut = static_cast<std::int64_t>(value);
    const double rest = value - static_cast<double>(cut);
    return cut + (rest >= 0.5 ? 1 : 0) - (rest <= -0.5 ? 1 : 0);
}

/// A position is accepted only if 64-bit arithmetic on it cannot overflow; an absurd one is outside
/// of any image.
std::int64_t fixed(double pixels) noexcept {
    constexpr double kFar = 1e12;
    return pixels > -kFar && pixels < kFar ? rounded(pixels * static_cast<double>(PixelPlace::kOne))
                                           : static_cast<std::int64_t>(-kFar) * PixelPlace::kOne;
}

}  // namespace

PixelMap::PixelMap(const grid::Frame& frame, const Image& image) : m_frame(&frame) {
    const auto& g = image.geo();
    const double det = g[1] * g[5] - g[2] * g[4];
    m_inverse = {(g[2] * g[3] - g[5] * g[0]) / det, g[5] / det,  -g[2] / det,
                 (g[4] * g[0] - g[1] * g[3]) / det, -g[4] / det, g[1] / det};
    std::vector<double> x;
    std::vector<double> y;
    outline(image, x, y);
    if (image.crs() && !image.crs()->same_horizontal(frame.crs())) {
        try {
            geo::Transform(*image.crs(), frame.crs()).apply(x, y);
            m_to_image = std::make_unique<geo::Transform>(frame.crs(), *image.crs());
        } catch (const util::Error& e) {
            throw util::Error("read the orthophoto " + image.path().string() +
                              ": cannot be moved to " + frame.crs().name() + ": " + e.what());
        }
    }
    const auto [west, east] = std::minmax_element(x.begin(), x.end());
    const auto [south, north] = std::minmax_element(y.begin(), y.end());
    m_extent = {frame.x(*west), frame.z(*north), frame.x(*east), frame.z(*south)};
    // Between its points, an outline deviates by less than 1/64 of an edge, whatever the
    // projection.
    m_room = 2 + std::max(m_extent.x1 - m_extent.x0, m_extent.z1 - m_extent.z0) / 64;
    const double cx = std::clamp((m_extent.x0 + m_extent.x1) / 2, -1e9, 1e9);
    const double cz = std::clamp((m_extent.z0 + m_extent.z1) / 2, -1e9, 1e9);
    const auto index = [](double v) { return static_cast<std::int32_t>(std::floor(v / kCell)); };
    const Cell middle = cells(index(cx), index(cz), 1, 1).front();
    const double area = (middle.u[1] - middle.u[0]) * (middle.v[2] - middle.v[0]) -
                        (middle.u[2] - middle.u[0]) * (middle.v[1] - middle.v[0]);
    m_pixels_per_voxel = std::sqrt(std::abs(area)) / kCell;
}

grid::ColumnRect PixelMap::influence() const noexcept {
    // A column counts when its centre lies in the image; only an outline in another CRS is not
    // exactly known.
    const double room = m_to_image ? m_room : 1;
    const auto cut = [](double v, double otherwise) {
        return static_cast<std::int32_t>(std::isfinite(v) ? std::clamp(v, -2e9, 2e9) : otherwise);
    };
    return {cut(std::floor(m_extent.x0 - room), -2e9), cut(std::floor(m_extent.z0 - room), -2e9),
            cut(std::ceil(m_extent.x1 + room), 2e9), cut(std::ceil(m_extent.z1 + room), 2e9)};
}

ColumnRect PixelMap::covered(const ColumnRect& rect) const noexcept {
    const auto cut = [](double v, std::int32_t from, int size) {
        return static_cast<int>(std::clamp(v - from, 0.0, static_cast<double>(size)));
    };
    const int x0 = cut(std::floor(m_extent.x0 - m_room), rect.x, rect.width);
    const int x1 = cut(std::ceil(m_extent.x1 + m_room), rect.x, rect.width);
    const int z0 = cut(std::floor(m_extent.z0 - m_room), rect.z, rect.height);
    const int z1 = cut(std::ceil(m_extent.z1 + m_room), rect.z, rect.height);
    if (x0 >= x1 || z0 >= z1)
        return {};
    return {rect.x + x0, rect.z + z0, x1 - x0, z1 - z0};
}

void PixelMap::to_pixels(std::vector<double>& e, std::vector<double>& n) const {
    if (m_to_image)
        m_to_image->apply(e, n);
    for (std::size_t i = 0; i < e.size(); ++i) {
        const double u = m_inverse[0] + e[i] * m_inverse[1] + n[i] * m_inverse[2];
        const double v = m_inverse[3] + e[i] * m_inverse[4] + n[i] * m_inverse[5];
        e[i] = u;
        n[i] = v;
    }
}

std::vector<PixelMap::Cell> PixelMap::cells(std::int32_t x0, std::int32_t z0, int nx,
                                            int nz) const {
    std::vector<double> e;
    std::vector<double> n;
    for (int j = 0; j <= nz; ++j)
        for (int i = 0; i <= nx; ++i) {
            e.push_back(m_frame->easting((static_cast<double>(x0) + i) * kCell));
            n.push_back(m_frame->northing((static_cast<double>(z0) + j) * kCell));
        }
    to_pixels(e, n);
    std::vector<Cell> out(static_cast<std::size_t>(nx) * static_cast<std::size_t>(nz));
    for (int j = 0; j < nz; ++j)
        for (int i = 0; i < nx; ++i) {
            const auto row = static_cast<std::size_t>(nx + 1);
            const auto at = static_cast<std::size_t>(j) * row + static_cast<std::size_t>(i);
            out[static_cast<std::size_t>(j) * static_cast<std::size_t>(nx) +
                static_cast<std::size_t>(i)] = {{e[at], e[at + 1], e[at + row], e[at + row + 1]},
                                                {n[at], n[at + 1], n[at + row], n[at + row + 1]}};
        }
    return out;
}

PixelPlace PixelMap::Cell::centre(int x, int z) const noexcept {
    const double fx = (x + 0.5) / kCell;
    const double fz = (z + 0.5) / kCell;
    const auto at = [&](const std::array<double, 4>& c) {
        return (c[0] + (c[1] - c[0]) * fx) * (1 - fz) + (c[2] + (c[3] - c[2]) * fx) * fz;
    };
    return {fixed(at(u)), fixed(at(v))};
}

PixelPlace PixelMap::Cell::step_x() const noexcept {
    return {fixed((u[1] - u[0]) / kCell), fixed((v[1] - v[0]) / kCell)};
}

PixelPlace PixelMap::Cell::step_z() const noexcept {
    return {fixed((u[2] - u[0]) / kCell), fixed((v[2] - v[0]) / kCell)};
}

}  // namespace terravox::imagery
