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
    if (image.crs() && image.crs()->geographic()) {
        const auto [west, east] = std::minmax_element(x.begin(), x.end());
        m_middle_deg = (*west + *east) / 2;
    }
    if (image.crs() && !image.crs()->same_horizontal(frame.crs())) {
        try {
            geo::Transform(*image.crs(), frame.crs()).apply(x, y);
            m_to_image = std::make_unique<geo::Transform>(frame.crs(), *image.crs());
        } catch (const util::Error& e) {
            throw util::Error("read the orthophoto {}: cannot be moved to {}: {}",
                              image.path().string(), frame.crs().name(), e.what());
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
    // PROJ's longitudes are within 180 degrees of Greenwich, those of an image may go on to 360.
    if (m_middle_deg)
        for (double& lon_deg : e)
            lon_deg += 360 * std::round((*m_middle_deg - lon_deg) / 360);
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

namespace {

constexpr int kShift = 16;
static_assert(PixelPlace::kOne == std::int64_t{1} << kShift);

/// Accumulates weighted pixels.
struct Sum {
    std::uint64_t r = 0;
    std::uint64_t g = 0;
    std::uint64_t b = 0;
    std::uint64_t nir = 0;
    std::uint64_t weight = 0;
    void add(const Pixel& p, std::uint64_t w) noexcept {
        r += w * p.r;
        g += w * p.g;
        b += w * p.b;
        nir += w * p.nir;
        weight += w;
    }
    [[nodiscard]] Pixel mean() const noexcept {
        const auto part = [&](std::uint64_t sum) {
            return static_cast<std::uint8_t>((sum + weight / 2) / weight);
        };
        return {part(r), part(g), part(b), part(nir)};
    }
};

/// Access to the pixels of a window by image coordinates.
class View {
public:
    explicit View(const Pixels& pixels) noexcept
        : m_pixels(pixels), m_all_valid(pixels.valid.empty()) {}
    [[nodiscard]] bool holds(std::int64_t u, std::int64_t v) const noexcept {
        const PixelWindow& w = m_pixels.window;
        return u >= w.x && v >= w.y && u < std::int64_t{w.x} + w.width &&
               v < std::int64_t{w.y} + w.height;
    }
    [[nodiscard]] std::size_t index(std::int64_t u, std::int64_t v) const noexcept {
        return static_cast<std::size_t>((v - m_pixels.window.y) * m_pixels.window.width +
                                        (u - m_pixels.window.x));
    }
    [[nodiscard]] bool has(std::int64_t u, std::int64_t v) const noexcept {
        return holds(u, v) && (m_all_valid || m_pixels.valid[index(u, v)] != 0);
    }
    [[nodiscard]] const Pixel& at(std::int64_t u, std::int64_t v) const noexcept {
        return m_pixels.values[index(u, v)];
    }
    [[nodiscard]] bool all_valid() const noexcept { return m_all_valid; }

private:
    const Pixels& m_pixels;
    bool m_all_valid;
};

Pixel bilinear(const View& view, PixelPlace centre) noexcept {
    // Shifted so that pixel centres are integers.
    const std::int64_t u = centre.u - PixelPlace::kOne / 2;
    const std::int64_t v = centre.v - PixelPlace::kOne / 2;
    const std::int64_t iu = u >> kShift;
    const std::int64_t iv = v >> kShift;
    const auto fu = static_cast<std::uint64_t>(u & (PixelPlace::kOne - 1));
    const auto fv = static_cast<std::uint64_t>(v & (PixelPlace::kOne - 1));
    if (fu == 0 && fv == 0)
        return view.at(iu, iv);  // where pixels are columns, each would divide by the weight
    constexpr auto kOne = static_cast<std::uint64_t>(PixelPlace::kOne);
    Sum sum;
    const auto tap = [&](std::int64_t tu, std::int64_t tv, std::uint64_t weight) {
        if (weight != 0 && view.has(tu, tv))
            sum.add(view.at(tu, tv), weight);
    };
    tap(iu, iv, (kOne - fu) * (kOne - fv));
    tap(iu + 1, iv, fu * (kOne - fv));
    tap(iu, iv + 1, (kOne - fu) * fv);
    tap(iu + 1, iv + 1, fu * fv);
    return sum.mean();  // the pixel under the centre has data and at least a quarter of the weight
}

/// For samples that all lie in the window and have data: plain 32-bit sums.
Pixel plain_mean(const View& view, PixelPlace centre, const PixelPlace* offsets,
                 int count) noexcept {
    std::uint32_t r = 0;
    std::uint32_t g = 0;
    std::uint32_t b = 0;
    std::uint32_t nir = 0;
    for (int i = 0; i < count; ++i) {
        const Pixel& p =
            view.at((centre.u + offsets[i].u) >> kShift, (centre.v + offsets[i].v) >> kShift);
        r += p.r;
        g += p.g;
        b += p.b;
        nir += p.nir;
    }
    const auto n = static_cast<std::uint32_t>(count);
    const auto part = [&](std::uint32_t sum) {
        return static_cast<std::uint8_t>((sum + n / 2) / n);
    };
    return {part(r), part(g), part(b), part(nir)};
}

}  // namespace

int samples_for(double pixels_per_voxel) noexcept {
    // Pixels as wide as voxels: bilinear interpolation equals their mean over a column.
    constexpr double kSame = 1.0 + 1e-6;
    if (!(pixels_per_voxel > kSame))
        return 1;
    return static_cast<int>(std::clamp(std::ceil(pixels_per_voxel - 1e-6), 4.0, 16.0));
}

ColumnPlaces find_places(const PixelMap& map, const ColumnRect& rect) {
    constexpr int kCell = PixelMap::kCell;
    ColumnPlaces out;
    out.rect = rect;
    out.samples = samples_for(map.pixels_per_voxel());
    const std::int32_t cx0 = rect.x >> 6;
    const std::int32_t cz0 = rect.z >> 6;
    static_assert(kCell == 64);
    const int nx = ((rect.x + rect.width - 1) >> 6) - cx0 + 1;
    const int nz = ((rect.z + rect.height - 1) >> 6) - cz0 + 1;
    const auto cells = map.cells(cx0, cz0, nx, nz);
    const auto count = static_cast<std::size_t>(rect.width) * static_cast<std::size_t>(rect.height);
    out.centres.reserve(count);
    out.cell.reserve(count);
    for (std::int32_t z = rect.z; z < rect.z + rect.height; ++z)
        for (std::int32_t x = rect.x; x < rect.x + rect.width; ++x) {
            const auto cell = static_cast<std::uint32_t>(((z >> 6) - cz0) * nx + (x >> 6) - cx0);
            out.centres.push_back(cells[cell].centre(x & 63, z & 63));
            out.cell.push_back(cell);
        }
    const int n = out.samples;
    for (const auto& cell : cells) {
        const PixelPlace dx = cell.step_x();
        const PixelPlace dz = cell.step_z();
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                // In units of 1/2n of a column from its centre.
                const std::int64_t a = 2 * i + 1 - n;
                const std::int64_t b = 2 * j + 1 - n;
                out.offsets.push_back(
                    {(a * dx.u + b * dz.u) / (2 * n), (a * dx.v + b * dz.v) / (2 * n)});
            }
    }
    return out;
}

PixelWindow find_window(const ColumnPlaces& places, int image_width, int image_height) noexcept {
    // Bilinear interpolation needs one pixel more.
    std::int64_t reach_u = PixelPlace::kOne;
    std::int64_t reach_v = PixelPlace::kOne;
    for (const PixelPlace& o : places.offsets) {
        reach_u = std::max(reach_u, std::abs(o.u) + 1);
        reach_v = std::max(reach_v, std::abs(o.v) + 1);
    }
    const std::int64_t end_u = std::int64_t{image_width} << kShift;
    const std::int64_t end_v = std::int64_t{image_height} << kShift;
    std::int64_t u0 = end_u;
    std::int64_t u1 = -1;
    std::int64_t v0 = end_v;
    std::int64_t v1 = -1;
    for (const PixelPlace& c : places.centres) {
        if (c.u < 0 || c.v < 0 || c.u >= end_u || c.v >= end_v)
            continue;
        u0 = std::min(u0, c.u);
        u1 = std::max(u1, c.u);
        v0 = std::min(v0, c.v);
        v1 = std::max(v1, c.v);
    }
    if (u1 < u0)
        return {};
    const auto low = [](std::int64_t v) {
        return static_cast<int>(std::max<std::int64_t>(v >> kShift, 0));
    };
    const int x0 = low(u0 - reach_u);
    const int y0 = low(v0 - reach_v);
    const int x1 =
        static_cast<int>(std::min<std::int64_t>(((u1 + reach_u) >> kShift) + 1, image_width));
    const int y1 =
        static_cast<int>(std::min<std::int64_t>(((v1 + reach_v) >> kShift) + 1, image_height));
    return {x0, y0, x1 - x0, y1 - y0};
}

bool mean_at(const ColumnPlaces& places, std::size_t index, const Pixels& pixels,
             Pixel& out) noexcept {
    const View view(pixels);
    const PixelPlace centre = places.centres[index];
    if (!view.has(centre.u >> kShift, centre.v >> kShift))
        return false;
    if (places.samples == 1) {
        out = bilinear(view, centre);
        return true;
    }
    const int count = places.samples * places.samples;
    const PixelPlace* offsets =
        &places.offsets[places.cell[index] * static_cast<std::size_t>(count)];
    // A footprint is a parallelogram, so it is bounded by its four corners.
    const auto inside = [&](int i) {
        return view.holds((centre.u + offsets[i].u) >> kShift, (centre.v + offsets[i].v) >> kShift);
    };
    const int n = places.samples;
    if (view.all_valid() && inside(0) && inside(n - 1) && inside(count - n) && inside(count - 1)) {
        out = plain_mean(view, centre, offsets, count);
        return true;
    }
    Sum sum;
    for (int i = 0; i < count; ++i) {
        const std::int64_t u = (centre.u + offsets[i].u) >> kShift;
        const std::int64_t v = (centre.v + offsets[i].v) >> kShift;
        if (view.has(u, v))
            sum.add(view.at(u, v), 1);
    }
    if (sum.weight == 0)
        sum.add(view.at(centre.u >> kShift, centre.v >> kShift), 1);
    out = sum.mean();
    return true;
}

}  // namespace terravox::imagery
