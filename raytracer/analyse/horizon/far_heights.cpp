#include "raytracer/analyse/horizon/far_heights.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/util/error.hpp"

namespace terravox::analyse {
namespace {

using heightmap::HeightFile;

constexpr int kMaxSide = 4096;

/// Cells of a grid that cover a part of one of its axes: [begin, end).
struct CellRange {
    int begin = 0;
    int end = 0;
};

/// @param first, step of the grid along the axis; step < 0: it runs against the axis
CellRange cells_over(double low, double high, double first, double step, int count) noexcept {
    const double a = (low - first) / step;
    const double b = (high - first) / step;
    const double limit = count;
    return {static_cast<int>(std::clamp(std::floor(std::min(a, b)), 0.0, limit)),
            static_cast<int>(std::clamp(std::ceil(std::max(a, b)), 0.0, limit))};
}

struct Window {
    HeightFile::Grid grid;
    CellRange x;
    CellRange y;
    [[nodiscard]] int width() const noexcept { return x.end - x.begin; }
    [[nodiscard]] int height() const noexcept { return y.end - y.begin; }
};

/// The finest cells of an area that fit memory.
/// @throws Error where even the coarsest ones do not: of strips that are a cell wide
Window find_window(const HeightFile& file, const FarHeights::Area& area) {
    const double size = std::max(area.east - area.west, area.north - area.south);
    for (double side = size / kMaxSide; side <= size; side *= 2) {
        const HeightFile::Grid grid = file.grid_for(side);
        const Window out{grid, cells_over(area.west, area.east, grid.x0, grid.dx, grid.width),
                         cells_over(area.south, area.north, grid.y0, grid.dy, grid.height)};
        if (out.width() <= kMaxSide && out.height() <= kMaxSide)
            return out;
    }
    throw util::Error("look at the horizon: " + file.path().string() + " is a strip of more than " +
                      std::to_string(kMaxSide) +
                      " cells; allowed: a raster of heights around the data");
}

}  // namespace

FarHeights::FarHeights(const std::filesystem::path& path, const geo::Crs& crs, const Area& area,
                       double metres_per_unit) {
    HeightFile file({path, std::nullopt, crs, std::nullopt});
    const Window window = find_window(file, area);
    const auto refuse = [&] {
        throw util::Error("look at the horizon: " + path.string() +
                          " has no heights there; allowed: a raster of heights around the data");
    };
    if (window.width() < 1 || window.height() < 1)
        refuse();
    m_grid = window.grid;
    m_cells = file.read(m_grid, window.x.begin, window.y.begin, window.width(), window.height());
    m_cell_m = std::max(std::abs(m_grid.dx), std::abs(m_grid.dy)) * metres_per_unit;
    m_highest_m = -HUGE_VAL;
    for (const double height_m : m_cells.metres)
        if (!std::isnan(height_m))
            m_highest_m = std::max(m_highest_m, height_m);
    if (!std::isfinite(m_highest_m))
        refuse();
}

std::optional<double> FarHeights::at(double easting, double northing) const noexcept {
    const double x = (easting - m_grid.x0) / m_grid.dx - 0.5 - m_cells.x;
    const double y = (northing - m_grid.y0) / m_grid.dy - 0.5 - m_cells.y;
    if (!(x >= 0 && y >= 0 && x <= m_cells.width - 1.0 && y <= m_cells.height - 1.0))
        return std::nullopt;
    const int left = std::min(static_cast<int>(x), std::max(0, m_cells.width - 2));
    const int top = std::min(static_cast<int>(y), std::max(0, m_cells.height - 2));
    const int right = std::min(left + 1, m_cells.width - 1);
    const int bottom = std::min(top + 1, m_cells.height - 1);
    const auto cell = [&](int column, int row) {
        return m_cells.at(m_cells.x + column, m_cells.y + row);
    };
    const double share = x - left;
    const double upper = cell(left, top) + (cell(right, top) - cell(left, top)) * share;
    const double lower = cell(left, bottom) + (cell(right, bottom) - cell(left, bottom)) * share;
    const double height_m = upper + (lower - upper) * (y - top);
    return std::isnan(height_m) ? std::nullopt : std::optional(height_m);
}

}  // namespace terravox::analyse
