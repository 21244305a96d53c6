#include "raytracer/analyse/raster/relief.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace terravox::analyse {
namespace {

constexpr double kDegPerRad = 180 / std::numbers::pi;

/// The nearest known height in one direction.
struct Known {
    float height = core::kNoData;
    int steps = 0;
};

/// Calls visit(x, y) so that the cell at (x + dx, y + dy) always comes before (x, y).
template <class Visit>
void each_cell_after(const CellPatch& patch, int dx, int dy, const Visit& visit) {
    for (int row = 0; row < patch.height; ++row)
        for (int column = 0; column < patch.width; ++column)
            visit(dx > 0 ? patch.width - 1 - column : column,
                  dy > 0 ? patch.height - 1 - row : row);
}

/// The weighted heights that have been found for one cell.
struct WeightedHeights {
    double sum = 0;
    double weight = 0;
};

void look_in_direction(const CellPatch& ground, int dx, int dy, int reach,
                       std::vector<Known>& known, std::vector<WeightedHeights>& found) {
    const double step2 = dx * dx + dy * dy;
    each_cell_after(ground, dx, dy, [&](int x, int y) {
        const std::size_t here = ground.index(x, y);
        known[here] = {ground.values[here], 0};
        if (ground.values[here] != core::kNoData)
            return;
        const int px = x + dx;
        const int py = y + dy;
        if (px < 0 || py < 0 || px >= ground.width || py >= ground.height)
            return;
        const Known& before = known[ground.index(px, py)];
        if (before.height == core::kNoData || before.steps + 1 > reach)
            return;
        known[here] = {before.height, before.steps + 1};
        const double steps = known[here].steps;
        const double weight = 1 / (steps * steps * step2);
        found[here].sum += weight * static_cast<double>(before.height);
        found[here].weight += weight;
    });
}

}  // namespace

void fill_ground(CellPatch& ground, const CellPatch& surface, int reach, CellPatch& source) {
    std::vector<Known> known(ground.values.size());
    std::vector<WeightedHeights> found(ground.values.size());
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            if (dx != 0 || dy != 0)
                look_in_direction(ground, dx, dy, reach, known, found);
    source = ground;
    for (std::size_t i = 0; i < ground.values.size(); ++i) {
        if (ground.values[i] != core::kNoData) {
            source.values[i] = kMeasuredGround;
            continue;
        }
        if (surface.values[i] == core::kNoData || found[i].weight == 0)
            continue;
        ground.values[i] =
            std::min(static_cast<float>(found[i].sum / found[i].weight), surface.values[i]);
        source.values[i] = kInterpolatedGround;
    }
}

std::optional<Gradient> gradient_at(const CellPatch& heights, int x, int y, int radius,
                                    double edge_m) {
    const float middle = heights.at(x, y);
    if (middle == core::kNoData)
        return std::nullopt;
    double n = 0;
    double sx = 0;
    double sy = 0;
    double sz = 0;
    double sxx = 0;
    double sxy = 0;
    double syy = 0;
    double sxz = 0;
    double syz = 0;
    for (int dy = std::max(-radius, -y); dy <= std::min(radius, heights.height - 1 - y); ++dy)
        for (int dx = std::max(-radius, -x); dx <= std::min(radius, heights.width - 1 - x); ++dx) {
            const float height = heights.at(x + dx, y + dy);
            if (height == core::kNoData)
                continue;
            const double z = static_cast<double>(height) - static_cast<double>(middle);
            n += 1;
            sx += dx;
            sy += dy;
            sz += z;
            sxx += dx * dx;
            sxy += dx * dy;
            syy += dy * dy;
            sxz += dx * z;
            syz += dy * z;
        }
    // About the mean of the cells, n times as large: whole numbers, so that zero is exact.
    const double xx = n * sxx - sx * sx;
    const double xy = n * sxy - sx * sy;
    const double yy = n * syy - sy * sy;
    const double xz = n * sxz - sx * sz;
    const double yz = n * syz - sy * sz;
    const double det = xx * yy - xy * xy;
    if (det <= 0)
        return std::nullopt;
    // Rows run to the south.
    return Gradient{(xz * yy - yz * xy) / det / edge_m, -(yz * xx - xz * xy) / det / edge_m};
}

double slope_deg(Gradient g) noexcept {
    return std::atan(std::hypot(g.east, g.north)) * kDegPerRad;
}

std::optional<double> aspect_deg(Gradient g) noexcept {
    if (g.east == 0 && g.north == 0)
        return std::nullopt;
    // `0 -`, not a sign, which would make a negative zero.
    const double clockwise = std::atan2(0 - g.east, 0 - g.north) * kDegPerRad;
    const double aspect = clockwise < 0 ? clockwise + 360 : clockwise;
    return aspect < 360 ? aspect : 0;
}

float hillshade(Gradient g, double azimuth_deg, double altitude_deg) noexcept {
    const double azimuth = azimuth_deg / kDegPerRad;
    const double altitude = altitude_deg / kDegPerRad;
    const double facing =
        (std::sin(altitude) -
         std::cos(altitude) * (std::sin(azimuth) * g.east + std::cos(azimuth) * g.north)) /
        std::sqrt(1 + g.east * g.east + g.north * g.north);
    return static_cast<float>(std::floor(1.5 + 254 * std::max(facing, 0.0)));
}

}  // namespace terravox::analyse
