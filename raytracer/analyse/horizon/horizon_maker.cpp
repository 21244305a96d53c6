#include "raytracer/analyse/horizon/horizon_maker.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>

#include "common/geo/crs.hpp"
#include "common/util/det_math.hpp"
#include "common/util/error.hpp"
#include "voxelserver/make/worlds/heightmap/height_file.hpp"

namespace terravox::analyse {

double Skyline::lift(const Place& before, const Place& at, const Place& after) {
    const double share =
        (at.distance_m - before.distance_m) / (after.distance_m - before.distance_m);
    return at.height_m - (before.height_m + (after.height_m - before.height_m) * share);
}

void Skyline::add(double distance_m, double height_m) {
    // What is farther away and no higher hides nothing more.
    if (height_m <= highest_m())
        return;
    const Place added{distance_m, height_m};
    while (m_places.size() >= 2 && lift(m_places[m_places.size() - 2], m_places.back(), added) <= 0)
        m_places.pop_back();
    m_places.push_back(added);
}

solar::FarHorizon::Tops Skyline::tops() const {
    constexpr double kLeast_m = 0.5;
    std::vector<Place> places = m_places;
    while (places.size() > 2) {
        std::size_t least = 0;
        double least_m = HUGE_VAL;
        for (std::size_t i = 1; i + 1 < places.size(); ++i) {
            const double lifted_m = lift(places[i - 1], places[i], places[i + 1]);
            if (lifted_m < least_m) {
                least = i;
                least_m = lifted_m;
            }
        }
        if (places.size() <= solar::FarHorizon::kMaxTops && least_m >= kLeast_m)
            break;
        places.erase(std::next(places.begin(), static_cast<std::ptrdiff_t>(least)));
    }
    solar::FarHorizon::Tops out;
    for (const Place& place : places) {
        const solar::FarTop top{static_cast<std::int32_t>(std::lround(place.distance_m)),
                                static_cast<std::int32_t>(std::lround(place.height_m))};
        const bool is_next = out.empty() || (top.distance_m > out.back().distance_m &&
                                             top.height_m > out.back().height_m);
        if (is_next)
            out.push_back(top);
    }
    return out;
}

namespace {

using heightmap::HeightFile;

/// A rectangle of the map, units of its CRS.
struct MapArea {
    double west = 0;
    double south = 0;
    double east = 0;
    double north = 0;
};

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
Window find_window(const HeightFile& file, const MapArea& area) {
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

/// Heights around a place, from a raster in any CRS, in memory: up to 4096 x 4096 of its cells, or
/// of an overview. Immutable.
class FarHeights {
public:
    /// Reads the heights of an area.
    /// @param crs of the map
    /// @param metres_per_unit of the map
    /// @throws Error naming the file: as heightmap::HeightFile, and where it has no cell in the
    /// area
    FarHeights(const std::filesystem::path& path, const geo::Crs& crs, const MapArea& area,
               double metres_per_unit) {
        HeightFile file({path, std::nullopt, crs, std::nullopt});
        const Window window = find_window(file, area);
        const auto refuse = [&] {
            throw util::Error(
                "look at the horizon: " + path.string() +
                " has no heights there; allowed: a raster of heights around the data");
        };
        if (window.width() < 1 || window.height() < 1)
            refuse();
        m_grid = window.grid;
        m_cells =
            file.read(m_grid, window.x.begin, window.y.begin, window.width(), window.height());
        m_cell_m = std::max(std::abs(m_grid.dx), std::abs(m_grid.dy)) * metres_per_unit;
        m_highest_m = -HUGE_VAL;
        for (const double height_m : m_cells.metres)
            if (!std::isnan(height_m))
                m_highest_m = std::max(m_highest_m, height_m);
        if (!std::isfinite(m_highest_m))
            refuse();
    }

    /// Bilinear between the middles of cells.
    /// @return metres above the sea; nullopt: there are none
    [[nodiscard]] std::optional<double> at(double easting, double northing) const noexcept {
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
        const double lower =
            cell(left, bottom) + (cell(right, bottom) - cell(left, bottom)) * share;
        const double height_m = upper + (lower - upper) * (y - top);
        return std::isnan(height_m) ? std::nullopt : std::optional(height_m);
    }
    /// Edge of a cell, metres.
    [[nodiscard]] double cell_m() const noexcept { return m_cell_m; }
    [[nodiscard]] double highest_m() const noexcept { return m_highest_m; }

private:
    heightmap::HeightFile::Grid m_grid;
    heightmap::Cells m_cells;
    double m_cell_m = 0;
    double m_highest_m = 0;
};
using solar::FarHorizon;

/// How far below the level plane of a place the Earth's surface appears at a distance.
double sunk_m(double distance_m) noexcept {
    constexpr double kEarth_m = 6'371'000;
    constexpr double kRefraction = 0.13;
    return distance_m * distance_m * (1 - kRefraction) / (2 * kEarth_m);
}

int points_over(double length_m) {
    constexpr double kApart_m = 250;
    return static_cast<int>(
        std::clamp(std::ceil(length_m / kApart_m) + 1, 2.0, double{FarHorizon::kMaxAcross}));
}

FarHorizon::Lattice lattice_over(const voxel::WorldInfo& world) {
    const voxel::VoxelBounds& bounds = world.bounds;
    const auto length_m = [&](std::size_t axis) {
        return (static_cast<double>(bounds.max[axis]) - bounds.min[axis]) * world.voxel_m;
    };
    FarHorizon::Lattice out;
    out.columns = points_over(length_m(0));
    out.rows = points_over(length_m(2));
    out.west = bounds.min[0];
    out.north = bounds.min[2];
    out.east = bounds.max[0];
    out.south = bounds.max[2];
    return out;
}

/// Where a line leaves the lattice's rectangle.
/// @param x, z within it
/// @return distance, level-0 voxels
double way_out(const FarHorizon::Lattice& lattice, double x, double z, double east, double south) {
    const auto along = [](double at, double low, double high, double direction) {
        if (direction > 0)
            return (high - at) / direction;
        return direction < 0 ? (low - at) / direction : HUGE_VAL;
    };
    return std::max(0.0, std::min(along(x, lattice.west, lattice.east, east),
                                  along(z, lattice.north, lattice.south, south)));
}

class HorizonMaker {
public:
    HorizonMaker(const HorizonSource& source, const voxel::WorldInfo& world)
        : m_world(world),
          m_range_m(source.range_m),
          m_lattice(lattice_over(world)),
          m_heights(source.file, geo::Crs::from_wkt(world.crs_wkt), area(),
                    world.voxel_m / world.crs_units_per_voxel) {}

    [[nodiscard]] const FarHorizon::Lattice& lattice() const noexcept { return m_lattice; }
    [[nodiscard]] FarHorizon::Tops tops(double x, double z, int azimuth) const {
        const double angle = azimuth * (2 * det::kPi / FarHorizon::kAzimuths);
        const det::SinCos direction = det::sin_cos(angle);
        const double east = direction.sin;
        const double south = -direction.cos;
        const double border_m = way_out(m_lattice, x, z, east, south) * m_world.voxel_m;
        // The data's own border belongs to both; there the two need not agree.
        Skyline skyline;
        double distance_m = border_m + m_heights.cell_m();
        while (distance_m <= std::min(border_m + m_range_m, double{FarHorizon::kMaxDistance_m}) &&
               m_heights.highest_m() - sunk_m(distance_m) > skyline.highest_m()) {
            const double voxels = distance_m / m_world.voxel_m;
            const auto height_m = m_heights.at((x + east * voxels) * m_world.crs_units_per_voxel,
                                               -(z + south * voxels) * m_world.crs_units_per_voxel);
            if (height_m)
                skyline.add(distance_m, *height_m - sunk_m(distance_m));
            constexpr double kShare = 0.005;
            distance_m += std::max(m_heights.cell_m(), distance_m * kShare);
        }
        return skyline.tops();
    }

private:
    [[nodiscard]] MapArea area() const noexcept {
        const double units = m_world.crs_units_per_voxel;
        const double range = m_range_m / m_world.voxel_m;
        return {(m_lattice.west - range) * units, -(m_lattice.south + range) * units,
                (m_lattice.east + range) * units, -(m_lattice.north - range) * units};
    }

    const voxel::WorldInfo& m_world;
    const double m_range_m;
    const FarHorizon::Lattice m_lattice;
    const FarHeights m_heights;
};

}  // namespace

void look_at_horizon(const HorizonSource& source, const voxel::WorldInfo& world,
                     scene::Scene& scene) {
    if (world.crs_wkt.empty())
        throw util::UsageError("look at the horizon: '" + world.title +
                               "' has no place on Earth; allowed: worlds with a CRS");
    const HorizonMaker maker(source, world);
    const FarHorizon::Lattice& lattice = maker.lattice();
    std::vector<FarHorizon::Tops> tops;
    tops.reserve(lattice.points() * FarHorizon::kAzimuths);
    for (int row = 0; row < lattice.rows; ++row)
        for (int column = 0; column < lattice.columns; ++column)
            for (int azimuth = 0; azimuth < FarHorizon::kAzimuths; ++azimuth)
                tops.push_back(maker.tops(lattice.x(column), lattice.z(row), azimuth));
    if (std::all_of(tops.begin(), tops.end(), [](const auto& some) { return some.empty(); }))
        throw util::Error("look at the horizon: no height of " + source.file.string() +
                          " is outside of the data; allowed: a raster of heights around the data");
    scene.analysis.horizon = solar::to_text(lattice, tops);
}

}  // namespace terravox::analyse
