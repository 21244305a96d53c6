// The cover of a square's land and the ground properties of its trees: the second half of
// SquareModel.
#include "common/thread/parallel.hpp"
#include "voxelserver/tools/survey/square_model.hpp"

namespace terravox::survey {
namespace {

/// Streets farther away do not make a garden or thin a forest.
constexpr double kStreetReach_m = 90;
constexpr double kStairs_m = 2.0;  ///< half the width of the stairs up to the church of the island

double ellipse(Vec2 p, Vec2 centre, double rx, double ry) noexcept {
    return length({(p.x - centre.x) / rx, (p.y - centre.y) / ry});
}

}  // namespace

void SquareModel::measure_streets(std::vector<float>& to_street) const {
    to_street.assign(m_ground.size(), 1e9F);
    for (const Road& road : m_roads.roads)
        for (std::size_t i = 0; i < road.line.size(); i += 3) {
            const Vec2 from = road.line[i].at;
            if (!road.line[i].houses || !m_area.expanded(kStreetReach_m).contains(from))
                continue;
            const int x0 = std::max(0, static_cast<int>(from.x - kStreetReach_m - m_area.x0));
            const int x1 =
                std::min(m_side - 1, static_cast<int>(from.x + kStreetReach_m - m_area.x0));
            const int y0 = std::max(0, static_cast<int>(from.y - kStreetReach_m - m_area.y0));
            const int y1 =
                std::min(m_side - 1, static_cast<int>(from.y + kStreetReach_m - m_area.y0));
            for (int row = y0; row <= y1; ++row)
                for (int column = x0; column <= x1; ++column) {
                    auto& best = to_street[index(column, row)];
                    best = std::min(best, static_cast<float>(length(place(column, row) - from)));
                }
        }
}

void SquareModel::lay_cover(int threads) {
    std::vector<float> to_street;
    measure_streets(to_street);
    thread::parallel_for(static_cast<std::size_t>(m_side), threads, [&](std::size_t row) {
        for (int column = 0; column < m_side; ++column) {
            const auto i = index(column, static_cast<int>(row));
            m_cover[i] = cover_at(column, static_cast<int>(row), to_street[i]);
        }
    });
}

std::optional<Cover> SquareModel::built_cover(Vec2 p, std::size_t i) const {
    for (const Site& site : m_terrain.sites()) {
        if (site.castle && ellipse(p, site.castle->centre, site.castle->radius_x_m,
                                   site.castle->radius_y_m) < 0.93)
            return Cover::kCourtyard;
        if (!site.island)
            continue;
        const Island& island = *site.island;
        if (ellipse(p, island.centre, island.radius_x_m, island.radius_y_m) < 0.42)
            return Cover::kCourtyard;
        if (std::abs(p.x - island.centre.x - 3.0) < kStairs_m && p.y < island.centre.y &&
            island.centre.y - p.y < island.radius_y_m * 1.1)
            return Cover::kGravelRoad;
    }
    if (m_road_edge[i] < 0.3F)
        return m_gravel[i] != 0 ? Cover::kGravelRoad : Cover::kRoad;
    return std::nullopt;
}

Cover SquareModel::cover_at(int column, int row, double to_street_m) const {
    const Vec2 p = place(column, row);
    if (const auto built = built_cover(p, index(column, row)))
        return *built;
    CoverSite at;
    at.at = p;
    at.ground_m = m_ground[index(column, row)];
    at.to_street_m = to_street_m;
    // One-sided at the rim of the margin, where there is no neighbour.
    const int east = std::min(column + 1, m_side - 1);
    const int west = std::max(column - 1, 0);
    const int north = std::min(row + 1, m_side - 1);
    const int south = std::max(row - 1, 0);
    at.slope = length(
        {(m_ground[index(east, row)] - m_ground[index(west, row)]) / (east - west),
         (m_ground[index(column, north)] - m_ground[index(column, south)]) / (north - south)});
    double valley_m = 0;
    double nearest_river = 1e18;
    for (const River& river : m_terrain.rivers()) {
        const double away = std::abs(p.y - static_cast<double>(river.index()) * kRiverSpacing_m);
        if (away < nearest_river) {
            nearest_river = away;
            valley_m = river.level_m(p.x);
        }
    }
    at.above_valley_m = at.ground_m - valley_m - 6.0;
    for (const Site& site : m_terrain.sites()) {
        if (site.lake && length(p - site.lake->centre) < site.lake->reach_m() + 30.0)
            at.to_water_m = site.lake->shore_distance(p);
        if (site.island &&
            ellipse(p, site.island->centre, site.island->radius_x_m, site.island->radius_y_m) < 1.3)
            at.island = true;
    }
    return natural_cover(m_seed, at);
}

TreeGround SquareModel::tree_ground(Vec2 p) const {
    TreeGround land;
    land.cover = cover(p);
    land.ground_m = ground_m(p);
    land.to_obstacle_m = bilinear(m_clear, p);
    land.wet = land.ground_m < static_cast<double>(m_water[nearest(p)]) + 0.3;
    for (const River& river : m_terrain.rivers()) {
        const RiverAtX at = river.at(p.x);
        const double bank = std::abs(p.y - at.centre_y) * at.stretch - at.half_width_m;
        if (bank < land.to_river_m) {
            land.to_river_m = bank;
            land.above_valley_m = land.ground_m - at.level_m;
        }
    }
    for (const Site& site : m_terrain.sites()) {
        if (site.brook && std::abs(p.x - site.centre.x) < 300.0)
            land.to_river_m = std::min(
                land.to_river_m, site.brook->nearest(p).distance_m - site.brook->half_width_m);
        if (site.island && length(p - site.island->centre) < 60.0)
            land.island = true;
        // The view of the castle's walls, and from them, is kept free.
        if (site.castle &&
            ellipse(p, site.castle->centre, site.castle->radius_x_m, site.castle->radius_y_m) < 1.3)
            land.to_obstacle_m = 0;
    }
    return land;
}

}  // namespace terravox::survey
