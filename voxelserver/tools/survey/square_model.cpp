// The cover of a square's land and the ground properties of its trees: the second half of
// SquareModel.
#include "voxelserver/tools/survey/square_model.hpp"

#include "common/thread/parallel.hpp"
#include "voxelserver/tools/survey/building.hpp"

namespace terravox::survey {
namespace {

constexpr double kFar_m = 30;        ///< distances to roads and obstacles are limited to this
constexpr double kShoulder_m = 6.5;  ///< over which a road's bed comes down to the land
constexpr double kTreeMargin_m = 40;
constexpr double kWireClearance_m = 7;  ///< no tree nearer to a power line

}  // namespace

Box2 SquareExtent::box() const noexcept {
    const double x = static_cast<double>(east_m) - kPlaceEasting_m;
    const double y = static_cast<double>(north_m) - kPlaceNorthing_m;
    return {x, y, x + size_m, y + size_m};
}

std::string SquareExtent::name() const {
    const std::int64_t unit =
        size_m == 1000 && east_m % 1000 == 0 && north_m % 1000 == 0 ? 1000 : 1;
    return "TM_" + std::to_string(east_m / unit) + "_" + std::to_string(north_m / unit);
}

SquareModel::SquareModel(std::uint64_t seed, const SquareExtent& extent, int threads)
    : m_seed(seed),
      m_extent(extent),
      m_area(extent.box().expanded(kModelMargin_m)),
      m_side(extent.size_m + 2 * kModelMargin_m + 1),
      m_terrain(seed, m_area),
      m_roads(build_roads(m_terrain, m_area)),
      m_power_line(build_power_line(m_terrain, m_area)) {
    const auto nodes = static_cast<std::size_t>(m_side) * static_cast<std::size_t>(m_side);
    m_ground.resize(nodes);
    m_water.resize(nodes);
    m_cover.resize(nodes);
    m_gravel.resize(nodes);
    m_road_edge.assign(nodes, static_cast<float>(kFar_m));
    m_clear.assign(nodes, static_cast<float>(kFar_m));
    shape_ground(threads);
    build_road_bed();
    gather_buildings();
    mark_obstacles();
    lay_cover(threads);
    m_trees = grow_trees(seed, extent.box().expanded(kTreeMargin_m),
                         [this](Vec2 p) { return tree_ground(p); });
}

std::size_t SquareModel::index(int column, int row) const noexcept {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(m_side) +
           static_cast<std::size_t>(column);
}

Vec2 SquareModel::place(int column, int row) const noexcept {
    return {m_area.x0 + column, m_area.y0 + row};
}

std::size_t SquareModel::nearest(Vec2 p) const noexcept {
    return index(static_cast<int>(std::floor(p.x + 0.5) - m_area.x0),
                 static_cast<int>(std::floor(p.y + 0.5) - m_area.y0));
}

SquareModel::Node SquareModel::node_below(Vec2 p) const noexcept {
    // The fractions are taken before the corner of the area is subtracted: they are then exact, and
    // so the same in any square.
    const double x = std::floor(p.x);
    const double y = std::floor(p.y);
    return {index(static_cast<int>(x - m_area.x0), static_cast<int>(y - m_area.y0)), p.x - x,
            p.y - y};
}

double SquareModel::bilinear(const std::vector<float>& field, Vec2 p) const noexcept {
    const auto [i, fx, fy] = node_below(p);
    const auto above = i + static_cast<std::size_t>(m_side);
    return lerp(lerp(field[i], field[i + 1], fx), lerp(field[above], field[above + 1], fx), fy);
}

double SquareModel::ground_m(Vec2 p) const noexcept {
    return bilinear(m_ground, p);
}

double SquareModel::road_edge_m(Vec2 p) const noexcept {
    return bilinear(m_road_edge, p);
}

Cover SquareModel::cover(Vec2 p) const noexcept {
    return m_cover[nearest(p)];
}

std::optional<double> SquareModel::water_m(Vec2 p) const noexcept {
    const double level = m_water[nearest(p)];
    if (level <= kNoWater || bilinear(m_ground, p) >= level)
        return std::nullopt;
    return level;
}

Vec2 SquareModel::gradient(Vec2 p) const noexcept {
    const auto i = nearest(p);
    const auto side = static_cast<std::size_t>(m_side);
    return {0.5 * (m_ground[i + 1] - m_ground[i - 1]),
            0.5 * (m_ground[i + side] - m_ground[i - side])};
}

void SquareModel::shape_ground(int threads) {
    std::vector<Terrain::Column> columns;
    for (int i = 0; i < m_side; ++i)
        columns.push_back(m_terrain.column(m_area.x0 + i));
    thread::parallel_for(static_cast<std::size_t>(m_side), threads, [&](std::size_t row) {
        for (int i = 0; i < m_side; ++i) {
            const auto spot = m_terrain.at(columns[static_cast<std::size_t>(i)],
                                           m_area.y0 + static_cast<double>(row));
            const auto at = index(i, static_cast<int>(row));
            m_ground[at] = static_cast<float>(spot.ground_m);
            m_water[at] = static_cast<float>(spot.water_m);
        }
    });
}

template <class Visit>
void SquareModel::near_nodes(Vec2 p, double reach_m, const Visit& visit) const {
    const auto clamp_to_side = [&](double v) {
        return static_cast<int>(std::clamp(v, -1.0, static_cast<double>(m_side)));
    };
    const int c0 = std::max(0, clamp_to_side(std::floor(p.x - reach_m - m_area.x0)));
    const int c1 = std::min(m_side - 1, clamp_to_side(p.x + reach_m - m_area.x0 + 1.0));
    const int r0 = std::max(0, clamp_to_side(std::floor(p.y - reach_m - m_area.y0)));
    const int r1 = std::min(m_side - 1, clamp_to_side(p.y + reach_m - m_area.y0 + 1.0));
    for (int row = r0; row <= r1; ++row)
        for (int column = c0; column <= c1; ++column)
            visit(place(column, row), index(column, row));
}

// The height of a road bed is the weighted mean of all segments of road near a node, so that
// crossing roads meet smoothly.
void SquareModel::build_road_bed() {
    std::vector<float> weight(m_ground.size()), height(m_ground.size()), share(m_ground.size());
    for (const Road& road : m_roads.roads) {
        const double reach = road.half_width_m + kShoulder_m;
        for (std::size_t i = 1; i < road.line.size(); ++i) {
            const auto &a = road.line[i - 1], &b = road.line[i];
            if (a.on_bridge)
                continue;
            near_nodes(
                (a.at + b.at) * 0.5, reach + 0.5 * kRoadStep_m + 1.0, [&](Vec2 p, std::size_t n) {
                    const auto on = nearest_on_segment(p, a.at, b.at);
                    const double edge = on.distance_m - road.half_width_m;
                    if (edge < m_road_edge[n]) {
                        m_road_edge[n] = static_cast<float>(edge);
                        m_gravel[n] = road.surface == RoadSurface::kGravel;
                    }
                    if (on.distance_m >= reach)
                        return;
                    const double near = 1.0 - on.distance_m / reach;
                    const double w = near * near * near * near;
                    weight[n] += static_cast<float>(w);
                    height[n] += static_cast<float>(w * lerp(a.height_m, b.height_m, on.along));
                    share[n] = std::max(
                        share[n],
                        static_cast<float>(1.0 - smoothstep(0.6, kShoulder_m - 0.5, edge)));
                });
        }
    }
    for (std::size_t n = 0; n < m_ground.size(); ++n)
        if (weight[n] > 0 && !(m_water[n] > kNoWater && m_ground[n] < m_water[n]))
            m_ground[n] = static_cast<float>(lerp(m_ground[n], height[n] / weight[n], share[n]));
}

void SquareModel::gather_buildings() {
    for (const Site& site : m_terrain.sites()) {
        if (!m_area.expanded(kSiteReach_m).contains(site.centre))
            continue;
        for (const Building& building : build_village(m_terrain, site))
            if (building.bounds().overlaps(m_area))
                m_buildings.push_back(building);
    }
}

void SquareModel::mark_obstacles() {
    const auto closer = [&](std::size_t n, double distance) {
        m_clear[n] = std::min(m_clear[n], static_cast<float>(distance));
    };
    for (std::size_t n = 0; n < m_clear.size(); ++n)
        m_clear[n] = m_road_edge[n];
    for (const Building& b : m_buildings)
        near_nodes(b.centre, b.half_length_m + b.half_width_m + 4.0, [&](Vec2 p, std::size_t n) {
            const Vec2 from = p - b.centre;
            closer(n, std::max(std::abs(dot(from, b.direction)) - b.half_length_m,
                               std::abs(dot(from, turn_left(b.direction))) - b.half_width_m));
        });
    for (const Bridge& bridge : m_roads.bridges)
        near_nodes(bridge.centre, bridge.half_length_m + 6.0, [&](Vec2 p, std::size_t n) {
            closer(n, length(p - bridge.centre) - bridge.half_length_m);
        });
    for (const Wire& wire : m_power_line.wires)
        for (double along = 0; along <= 1.0; along += 0.03125)
            near_nodes(
                wire.a + (wire.b - wire.a) * along, kWireClearance_m + 3.0,
                [&](Vec2 p, std::size_t n) {
                    closer(n, nearest_on_segment(p, wire.a, wire.b).distance_m - kWireClearance_m);
                });
}

namespace {

/// Streets farther away do not make a garden or thin a forest.
constexpr double kStreetReach_m = 90;
constexpr double kStairs_m = 2.0;  ///< half the width of the stairs up to the church of the island

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
        if (site.castle && site.castle->outwards(p) < 0.93)
            return Cover::kCourtyard;
        if (!site.island)
            continue;
        const Mound& island = *site.island;
        if (island.outwards(p) < 0.42)
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
        if (site.island && site.island->outwards(p) < 1.3)
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
        if (site.castle && site.castle->outwards(p) < 1.3)
            land.to_obstacle_m = 0;
    }
    return land;
}

}  // namespace terravox::survey
