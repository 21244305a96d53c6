// Castle, churches and hotels: the parts of a site that are placed manually.
#include "voxelserver/tools/survey/building.hpp"

#include "voxelserver/tools/survey/randomness.hpp"

namespace terravox::survey {
namespace {

constexpr double kMerlon_m = 0.9;  ///< height of a battlement

bool separated_along(Vec2 axis, const Building& a, const Building& b, double margin_m) noexcept {
    const auto reach = [&](const Building& x) {
        return std::abs(dot(axis, x.direction)) * (x.half_length_m + margin_m) +
               std::abs(dot(axis, turn_left(x.direction))) * (x.half_width_m + margin_m);
    };
    return std::abs(dot(axis, b.centre - a.centre)) > reach(a) + reach(b);
}

}  // namespace

const char* to_name(RoofType type) noexcept {
    constexpr std::array kNames = {"gable", "hip", "flat", "pyramid", "cone"};
    return kNames[static_cast<std::size_t>(type)];
}

const char* to_name(RoofColour colour) noexcept {
    constexpr std::array kNames = {"red", "grey", "pale", "copper"};
    return kNames[static_cast<std::size_t>(colour)];
}

const char* to_name(BuildingUse use) noexcept {
    constexpr std::array kNames = {"house",  "shed",    "farm",    "hotel",  "church",
                                   "castle", "balcony", "carport", "canopy", "passage"};
    return kNames[static_cast<std::size_t>(use)];
}

std::optional<double> Building::top_m(Vec2 p) const noexcept {
    const Vec2 from = p - centre;
    const double along = std::abs(dot(from, direction));
    const double across = std::abs(dot(from, turn_left(direction)));
    if (along > half_length_m || across > half_width_m)
        return std::nullopt;
    const double rise = ridge_m - eaves_m;
    switch (roof) {
        case RoofType::kGable: return eaves_m + rise * (1.0 - across / half_width_m);
        case RoofType::kHip: {
            const double to_eaves = std::min(half_width_m - across, half_length_m - along);
            return eaves_m + rise * std::min(1.0, to_eaves / half_width_m);
        }
        case RoofType::kPyramid:
            return eaves_m + rise * (1.0 - std::max(along / half_length_m, across / half_width_m));
        case RoofType::kCone: {
            const double part = length(from) / half_width_m;
            if (part > 1.0)
                return std::nullopt;
            return eaves_m + rise * (1.0 - part);
        }
        case RoofType::kFlat: break;
    }
    const double step = (along + 1000.0) * 0.5;  // merlons and gaps of 2 m each
    return battlements && step - std::floor(step) < 0.5 ? eaves_m + kMerlon_m : eaves_m;
}

std::array<Vec2, 4> Building::corners(double margin_m) const noexcept {
    const Vec2 a = direction * (half_length_m + margin_m);
    const Vec2 b = turn_left(direction) * (half_width_m + margin_m);
    return {centre - a - b, centre + a - b, centre + a + b, centre - a + b};
}

std::vector<Vec2> Building::outline() const {
    if (roof != RoofType::kCone) {
        const auto four = corners();
        return {four.begin(), four.end()};
    }
    constexpr double kCos30 = 0.8660254037844386;
    std::vector<Vec2> ring;
    Vec2 arm = direction * half_width_m;
    for (int i = 0; i < 12; ++i) {
        ring.push_back(centre + arm);
        arm = arm * kCos30 + turn_left(arm) * 0.5;
    }
    return ring;
}

Box2 Building::bounds() const noexcept {
    Box2 box{centre.x, centre.y, centre.x, centre.y};
    for (const Vec2 corner : corners()) {
        box.x0 = std::min(box.x0, corner.x);
        box.x1 = std::max(box.x1, corner.x);
        box.y0 = std::min(box.y0, corner.y);
        box.y1 = std::max(box.y1, corner.y);
    }
    return box;
}

bool footprints_overlap(const Building& a, const Building& b, double margin_m) noexcept {
    for (const Vec2 axis :
         {a.direction, turn_left(a.direction), b.direction, turn_left(b.direction)})
        if (separated_along(axis, a, b, margin_m))
            return false;
    return true;
}

namespace {

// A part of a landmark; heights are above `base_m`, the floor of the landmark.
struct Part {
    double east_m, north_m;  ///< of the centre, along the landmark's direction and to its left
    double half_length_m;
    double half_width_m;
    double eaves_m;
    double ridge_m;
    RoofType roof;
    RoofColour colour;
    bool across = false;                     ///< ridge a quarter turn from the landmark's direction
    BuildingUse slab = BuildingUse::kHouse;  ///< what it is when it has an underside
    double underside_m = 0;                  ///< above 0: it hangs, or stands on another part
};

Building placed(const Part& part, Vec2 at, Vec2 direction, double base_m, BuildingUse use) {
    Building building;
    building.centre = at + direction * part.east_m + turn_left(direction) * part.north_m;
    building.direction = part.across ? turn_left(direction) : direction;
    building.half_length_m = part.half_length_m;
    building.half_width_m = part.half_width_m;
    building.ground_m = base_m;
    building.eaves_m = base_m + part.eaves_m;
    building.ridge_m = base_m + part.ridge_m;
    building.roof = part.roof;
    building.colour = part.colour;
    building.use = use;
    if (part.underside_m > 0) {
        building.use = part.slab;
        building.underside_m = base_m + part.underside_m;
    }
    return building;
}

void add_parts(const std::vector<Part>& parts, Vec2 at, Vec2 direction, double base_m,
               BuildingUse use, std::vector<Building>& out) {
    for (const Part& part : parts)
        out.push_back(placed(part, at, direction, base_m, use));
}

double lowest_ground(const Terrain& terrain, Vec2 at, Vec2 direction, double half_length_m,
                     double half_width_m) {
    double lowest = terrain.at(at).ground_m;
    for (const double s : {-1.0, 1.0})
        for (const double t : {-1.0, 1.0})
            lowest = std::min(lowest, terrain
                                          .at(at + direction * (s * half_length_m) +
                                              turn_left(direction) * (t * half_width_m))
                                          .ground_m);
    return lowest;
}

void add_parish_church(const Terrain& terrain, const Site& site, std::vector<Building>& out) {
    const double base = lowest_ground(terrain, site.church, site.church_direction, 16, 6);
    add_parts({{0, 0, 13, 5.5, 9, 16, RoofType::kGable, RoofColour::kGrey},
               {15.5, 0, 3.5, 3.5, 7.5, 11.5, RoofType::kHip, RoofColour::kGrey},
               {-15.5, 0, 2.9, 2.9, 24, 41, RoofType::kPyramid, RoofColour::kCopper}},
              site.church, site.church_direction, base, BuildingUse::kChurch, out);
}

void add_island_church(const Mound& island, std::vector<Building>& out) {
    const Vec2 east = unit({1.0, 0.18});
    add_parts({{2, 1, 10, 4.6, 9, 15.5, RoofType::kGable, RoofColour::kRed},
               {14, 1, 3, 3, 7.5, 11, RoofType::kHip, RoofColour::kRed},
               {-11.5, 1, 2.8, 2.8, 27, 50, RoofType::kPyramid, RoofColour::kCopper},
               {1, -13.5, 7, 3.6, 5.5, 9.5, RoofType::kHip, RoofColour::kRed},
               {-17, -8, 3.4, 2.8, 4, 6.5, RoofType::kGable, RoofColour::kRed, true}},
              island.centre, east, island.top_m, BuildingUse::kChurch, out);
}

// A ring of walls over the cliff with towers at its corners; hall, chapel and keep in the
// courtyard.
void add_castle(const Mound& rock, std::vector<Building>& out) {
    const std::vector<Vec2> ring = {{-37, -7}, {-20, -23}, {9, -25}, {33, -15},
                                    {38, 3},   {20, 22},   {-8, 25}, {-31, 14}};
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vec2 a = ring[i];
        const Vec2 b = ring[(i + 1) % ring.size()];
        Part wall{0, 0, 0.5 * length(b - a), 1.1, 8.0, 8.0, RoofType::kFlat, RoofColour::kPale};
        out.push_back(placed(wall, rock.centre + (a + b) * 0.5, unit(b - a), rock.top_m,
                             BuildingUse::kCastle));
        out.back().battlements = true;
        out.back().ground_m = rock.top_m - 1.5;
    }
    for (const std::size_t i : {std::size_t{0}, std::size_t{3}, std::size_t{5}, std::size_t{7}}) {
        const Part tower{ring[i].x,       ring[i].y,       4.4, 4.4, 13.5, 21.5,
                         RoofType::kCone, RoofColour::kRed};
        out.push_back(placed(tower, rock.centre, {1, 0}, rock.top_m, BuildingUse::kCastle));
    }
    add_parts({{-6, -18, 15, 4.8, 10.5, 17.5, RoofType::kGable, RoofColour::kRed},
               {18, -11, 8, 4.2, 8.5, 14, RoofType::kHip, RoofColour::kRed},
               {-22, 2, 9, 4.2, 8, 13.5, RoofType::kGable, RoofColour::kRed, true},
               {5, 23, 4.2, 4.2, 15, 22, RoofType::kPyramid, RoofColour::kRed},
               {21, 7, 4.6, 4.6, 25, 34, RoofType::kPyramid, RoofColour::kRed},
               {2, 7, 5.5, 3.1, 6, 10.5, RoofType::kGable, RoofColour::kGrey}},
              rock.centre, {1, 0}, rock.top_m, BuildingUse::kCastle, out);
}

void add_hotels(const Terrain& terrain, const Lake& lake, std::vector<Building>& out) {
    // Along the east shore, their long side to the water. A passage leads through the middle, from
    // the street to the shore, and a canopy stands before the door to the street.
    const std::vector<Vec2> directions = {unit({1, -0.12}), unit({1, 0.36})};
    const std::vector<double> storeys = {5, 4};
    for (std::size_t i = 0; i < directions.size(); ++i) {
        const Vec2 at = lake.shore_point(directions[i]) + directions[i] * 23.0;
        const Vec2 along = turn_left(directions[i]);
        const double base = lowest_ground(terrain, at, along, 19, 7);
        const double top = 1.5 + 3.2 * storeys[i];
        const auto flat = RoofType::kFlat;
        const auto pale = RoofColour::kPale;
        add_parts(
            {{-10.25, 0, 7.74, 6.5, top, top, flat, pale},
             {10.25, 0, 7.74, 6.5, top, top, flat, pale},
             {0, 0, 2.5, 6.5, top, top, flat, pale, false, BuildingUse::kPassage, 4.5},
             {0, 0, 7, 3, top + 3, top + 3, flat, pale, false, BuildingUse::kHotel, top - 0.5},
             {-9, -8.8, 5, 2.2, 5.0, 5.0, flat, RoofColour::kGrey, false, BuildingUse::kCanopy,
              4.6}},
            at, along, base, BuildingUse::kHotel, out);
    }
}

}  // namespace

std::vector<Building> build_landmarks(const Terrain& terrain, const Site& site) {
    std::vector<Building> out;
    add_parish_church(terrain, site, out);
    if (site.castle)
        add_castle(*site.castle, out);
    if (site.island)
        add_island_church(*site.island, out);
    if (site.is_the_place() && site.lake)
        add_hotels(terrain, *site.lake, out);
    std::uint32_t count = 0;
    for (Building& building : out)
        building.tint = static_cast<std::uint32_t>(compute_hash(site.seed, 0xB1, count++));
    return out;
}

}  // namespace terravox::survey
