#include "raytracer/analyse/horizon/horizon_maker.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "common/geo/crs.hpp"
#include "common/util/det_math.hpp"
#include "common/util/error.hpp"
#include "raytracer/analyse/horizon/far_heights.hpp"
#include "raytracer/analyse/solar/far_horizon.hpp"

namespace terravox::analyse {

double Skyline::lift(const Place& before, const Place& at, const Place& after) {
    const double share =
        (at.distance_m - before.distance_m) / (after.distance_m - before.distance_m);
    return at.height_m - (before.height_m + (after.height_m - before.height_m) * share);
}

double Skyline::highest_m() const noexcept {
    return m_places.empty() ? -HUGE_VAL : m_places.back().height_m;
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
    [[nodiscard]] FarHeights::Area area() const noexcept {
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
