#include "raytracer/analyse/raster/relief.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/util/error.hpp"

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

namespace {

/// Steps beyond which the ground is not interpolated, whatever the distance in metres: a block's
/// margin must stay small.
constexpr int kMaxReach = 256;

/// The derived values of a block's cells, row by row.
struct DerivedValues {
    std::vector<float> ground;
    std::vector<float> source;
    std::vector<float> above;
    std::vector<float> slope;
    std::vector<float> aspect;
    std::vector<float> shade;
};

class TerrainBlocks {
public:
    TerrainBlocks(CellFile& cells, double edge_m, const ReliefOptions& options)
        : m_cells(cells),
          m_edge_m(edge_m),
          m_options(options),
          m_radius(options.window / 2),
          m_reach(static_cast<int>(std::min<double>(options.fill_m / edge_m, kMaxReach))),
          // Slopes need filled ground around a cell, and each cell of it what it is filled from.
          m_margin(m_radius + m_reach) {}

    void derive(const CellRectangle& block) {
        read_around(block);
        fill_ground(m_ground, m_surface, m_reach, m_source);
        DerivedValues values;
        for (int y = 0; y < block.height; ++y)
            for (int x = 0; x < block.width; ++x)
                add_cell(x + m_margin, y + m_margin, values);
        m_cells.write("dtm", block, values.ground);
        m_cells.write("dtm_source", block, values.source);
        m_cells.write("ndsm", block, values.above);
        m_cells.write("slope", block, values.slope);
        m_cells.write("aspect", block, values.aspect);
        m_cells.write("hillshade", block, values.shade);
    }

private:
    void read_around(const CellRectangle& block) {
        const CellRectangle around{block.x0 - m_margin, block.y0 - m_margin,
                                   block.width + 2 * m_margin, block.height + 2 * m_margin};
        read("dsm", around, m_surface);
        read("dtm", around, m_ground);
        read("dtm_source", around, m_source);
        // Blocks that are finished have interpolated heights, from which nothing may follow: the
        // order of blocks would matter.
        for (std::size_t i = 0; i < m_ground.values.size(); ++i)
            if (m_source.values[i] == kInterpolatedGround)
                m_ground.values[i] = core::kNoData;
    }
    void add_cell(int x, int y, DerivedValues& to) const {
        const float ground = m_ground.at(x, y);
        to.ground.push_back(ground);
        to.source.push_back(m_source.at(x, y));
        to.above.push_back(ground == core::kNoData ? core::kNoData : m_surface.at(x, y) - ground);
        const CellPatch& relief = m_options.of == ReliefOf::kGround ? m_ground : m_surface;
        const auto gradient = gradient_at(relief, x, y, m_radius, m_edge_m);
        const auto aspect = gradient ? aspect_deg(*gradient) : std::nullopt;
        to.slope.push_back(gradient ? static_cast<float>(slope_deg(*gradient)) : core::kNoData);
        to.aspect.push_back(aspect ? static_cast<float>(*aspect) : core::kNoData);
        to.shade.push_back(gradient ? hillshade(*gradient, m_options.light_azimuth_deg,
                                                m_options.light_altitude_deg)
                                    : core::kNoData);
    }
    void read(std::string_view band, const CellRectangle& area, CellPatch& to) {
        to.width = area.width;
        to.height = area.height;
        m_cells.read(band, area, to.values);
    }

    CellFile& m_cells;
    const double m_edge_m;
    const ReliefOptions& m_options;
    const int m_radius;
    const int m_reach;
    const int m_margin;
    CellPatch m_surface;
    CellPatch m_ground;
    CellPatch m_source;
};

}  // namespace

void derive_terrain(CellFile& cells, double edge_m, const ReliefOptions& options,
                    const std::stop_token& stop) {
    TerrainBlocks blocks(cells, edge_m, options);
    // Whole blocks of the file, and large: margins are read again for each.
    constexpr int kLarge_px = 512;
    const int side = cells.block_px() * std::max(kLarge_px / cells.block_px(), 1);
    cells.each_block(side, [&](const CellRectangle& block) {
        if (stop.stop_requested())
            throw util::Error(cells.attempt() + ": interrupted");
        blocks.derive(block);
    });
}

}  // namespace terravox::analyse
