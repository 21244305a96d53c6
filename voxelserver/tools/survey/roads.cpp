#include "voxelserver/tools/survey/roads.hpp"

namespace terravox::survey {
namespace {

constexpr int kSmoothing = 6;   ///< vertices to each side that a road's height is averaged over
constexpr int kRampReach = 14;  ///< vertices that a ramp to a bridge may be long
constexpr double kRampSlope = 0.08;  ///< rise over run of a ramp
constexpr double kPathOffset_m = 9;  ///< from the shore to the path around a lake
/// Greatest step of land that the path climbs within its smoothing.
constexpr double kPathStep_m = 2.5;
constexpr double kValleyRoadReach_m = 400;

// Chaikin's corner cutting, which keeps the end points.
// Ref: Chaikin, "An Algorithm for High-Speed Curve Generation", Computer Graphics and Image
// Processing 3, 1974.
std::vector<Vec2> rounded(std::vector<Vec2> line) {
    for (int pass = 0; pass < 3; ++pass) {
        std::vector<Vec2> cut{line.front()};
        for (std::size_t i = 1; i < line.size(); ++i) {
            const Vec2 a = line[i - 1];
            const Vec2 b = line[i];
            if (i > 1)
                cut.push_back(a + (b - a) * 0.25);
            if (i + 1 < line.size())
                cut.push_back(a + (b - a) * 0.75);
        }
        cut.push_back(line.back());
        line = std::move(cut);
    }
    return line;
}

std::vector<Vec2> resampled(const std::vector<Vec2>& line) {
    std::vector<Vec2> out{line.front()};
    double left = kRoadStep_m;
    for (std::size_t i = 1; i < line.size(); ++i) {
        const Vec2 step = line[i] - line[i - 1];
        const double whole = length(step);
        double done = left;
        for (; done <= whole; done += kRoadStep_m)
            out.push_back(line[i - 1] + step * (done / whole));
        left = done - whole;
    }
    return out;
}

struct WaterBelow {
    double level_m = kNoWater;
    bool river = false;
};

// Deep water under the road; the dry bank counts, so that the deck reaches over it.
WaterBelow water_below(const Terrain& terrain, Vec2 p) {
    const auto column = terrain.column(p.x);
    for (int i = 0; i < column.count; ++i) {
        const RiverAtX& river = column.rivers[static_cast<std::size_t>(i)];
        if (std::abs(p.y - river.centre_y) * river.stretch < river.half_width_m + 3.0)
            return {river.level_m, true};
    }
    for (const Site& site : terrain.sites()) {
        if (!site.brook)
            continue;
        const auto near = site.brook->nearest(p);
        if (near.distance_m < site.brook->half_width_m + 1.5)
            return {near.level_m, false};
    }
    return {};
}

Road graded(const Terrain& terrain, const std::vector<Vec2>& line, double half_width_m,
            RoadSurface surface) {
    Road road;
    road.half_width_m = half_width_m;
    road.surface = surface;
    std::vector<double> land;
    for (const Vec2 p : line) {
        const auto spot = terrain.at(p);
        land.push_back(std::max(spot.ground_m, spot.water_m + 0.4));
    }
    const int count = static_cast<int>(line.size());
    for (int i = 0; i < count; ++i) {
        double sum = 0;
        int used = 0;
        for (int k = std::max(0, i - kSmoothing); k <= std::min(count - 1, i + kSmoothing);
             ++k, ++used)
            sum += land[static_cast<std::size_t>(k)];
        road.line.push_back({line[static_cast<std::size_t>(i)], sum / used, false, false});
    }
    return road;
}

// Raises the vertices next to a bridge so that the road climbs to the deck; no farther than
// kRampReach, so that a road can be built in pieces.
void lift_ramps(Road& road, int first, int last, double deck_m) {
    const int count = static_cast<int>(road.line.size());
    for (int i = std::max(0, first - kRampReach); i <= std::min(count - 1, last + kRampReach);
         ++i) {
        const int steps = std::max({0, first - i, i - last});
        auto& vertex = road.line[static_cast<std::size_t>(i)];
        const double ramp = deck_m - kRampSlope * kRoadStep_m * std::max(0, steps - 1);
        if (steps == 0)
            vertex.height_m = deck_m;
        else
            vertex.height_m = std::max(vertex.height_m, ramp);
    }
}

void add_bridges(const Terrain& terrain, Road& road, std::vector<Bridge>& bridges) {
    const int count = static_cast<int>(road.line.size());
    for (int i = 1; i + 1 < count; ++i) {
        WaterBelow water = water_below(terrain, road.line[static_cast<std::size_t>(i)].at);
        if (water.level_m == kNoWater)
            continue;
        int end = i;
        while (end + 2 < count &&
               water_below(terrain, road.line[static_cast<std::size_t>(end + 1)].at).level_m !=
                   kNoWater)
            ++end;
        const int first = i - 1;
        const int last = end + 1;
        const auto &a = road.line[static_cast<std::size_t>(first)],
                   &b = road.line[static_cast<std::size_t>(last)];
        const double clearance = water.river               ? kRiverClearance_m
                                 : road.half_width_m > 2.0 ? kBrookClearance_m
                                                           : 1.5;
        const double deck = std::max(water.level_m + clearance, std::max(a.height_m, b.height_m));
        bridges.push_back({(a.at + b.at) * 0.5, unit(b.at - a.at), 0.5 * length(b.at - a.at) + 0.5,
                           road.half_width_m + 0.9, deck, water.level_m});
        lift_ramps(road, first, last, deck);
        for (int k = first; k < last; ++k)
            road.line[static_cast<std::size_t>(k)].on_bridge = true;
        i = last;
    }
}

void add_road(const Terrain& terrain, const std::vector<Vec2>& line, double half_width_m,
              RoadSurface surface, RoadNet& net) {
    if (line.size() < 4)
        return;
    Road road = graded(terrain, line, half_width_m, surface);
    add_bridges(terrain, road, net.bridges);
    net.roads.push_back(std::move(road));
}

// The path is left out where the shore is a cliff.
void add_lake_path(const Terrain& terrain, const Lake& lake, RoadNet& net) {
    std::vector<Vec2> ring = lake.shore_ring(120);
    ring.push_back(ring.front());
    for (Vec2& p : ring)
        p = p + unit(p - lake.centre) * kPathOffset_m;
    std::vector<Vec2> piece;
    for (const Vec2 p : resampled(ring)) {
        if (terrain.at(p).ground_m < lake.level_m + kPathStep_m && terrain.slope(p) < 0.5) {
            piece.push_back(p);
            continue;
        }
        add_road(terrain, piece, 1.3, RoadSurface::kGravel, net);
        piece.clear();
    }
    add_road(terrain, piece, 1.3, RoadSurface::kGravel, net);
}

// Vertices stand at multiples of the step in x, so that neighbouring squares build the same road
// from different ends.
void add_valley_road(const Terrain& terrain, const River& river, const Box2& area, RoadNet& net) {
    const double south = river.centre_y(0.5 * (area.x0 + area.x1));
    if (south < area.y0 - 2 * kValleyRoadReach_m - kRiverSway_m ||
        south > area.y1 + 2 * kValleyRoadReach_m + kRiverSway_m)
        return;
    std::vector<Vec2> line;
    const double first = std::floor((area.x0 - kValleyRoadReach_m) / kRoadStep_m) * kRoadStep_m;
    for (double x = first; x <= area.x1 + kValleyRoadReach_m; x += kRoadStep_m) {
        // The road follows the river's large bends, not the small ones: the average over 120 m.
        double y = 0;
        for (int k = -3; k <= 3; ++k)
            y += river.centre_y(x + 20.0 * k) / 7.0;
        line.push_back({x, y + valley_road_offset_m(x, river.index())});
    }
    add_road(terrain, line, 3.2, RoadSurface::kAsphalt, net);
}

}  // namespace

double Bridge::top_m(Vec2 p) const noexcept {
    const Vec2 from = p - centre;
    const double across = std::abs(dot(from, turn_left(direction)));
    if (std::abs(dot(from, direction)) > half_length_m || across > half_width_m)
        return kNoWater;
    return across > half_width_m - 0.4 ? deck_m + kParapet_m : deck_m;
}

Box2 Bridge::bounds() const noexcept {
    const double reach = half_length_m + half_width_m;
    return {centre.x - reach, centre.y - reach, centre.x + reach, centre.y + reach};
}

RoadNet build_streets(const Terrain& terrain, const Site& site) {
    RoadNet net;
    for (const Street& street : site.streets) {
        add_road(terrain, resampled(rounded(street.controls)), street.half_width_m, street.surface,
                 net);
        auto& line = net.roads.back().line;
        const auto vertices = static_cast<double>(line.size());
        const bool houses = street.house_step_m > 0;
        for (std::size_t i = 0; i < line.size(); ++i) {
            const double part = static_cast<double>(i) / vertices;
            line[i].houses = houses && part >= street.houses_from && part <= street.houses_to;
        }
    }
    return net;
}

RoadNet build_roads(const Terrain& terrain, const Box2& area) {
    RoadNet net;
    for (const River& river : terrain.rivers())
        add_valley_road(terrain, river, area, net);
    for (const Site& site : terrain.sites()) {
        if (!area.expanded(kSiteReach_m).contains(site.centre))
            continue;
        RoadNet streets = build_streets(terrain, site);
        std::move(streets.roads.begin(), streets.roads.end(), std::back_inserter(net.roads));
        net.bridges.insert(net.bridges.end(), streets.bridges.begin(), streets.bridges.end());
        if (site.lake)
            add_lake_path(terrain, *site.lake, net);
    }
    return net;
}

}  // namespace terravox::survey
