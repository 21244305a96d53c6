#include "voxelserver/tools/survey/building.hpp"

#include <utility>

#include "voxelserver/tools/survey/randomness.hpp"

namespace terravox::survey {
namespace {

constexpr double kRoadClearance_m = 2.2;  ///< from a wall to the edge of any road
/// Each footprint is widened by this when houses are kept apart.
constexpr double kNeighbourGap_m = 1.6;
constexpr double kMaxSlope_m = 4.0;      ///< greatest difference of ground under a house
constexpr double kMaxSlabSlope_m = 1.0;  ///< the same under a balcony or carport
constexpr double kStorey_m = 3.2;        ///< clear height beneath them: more than one storey
constexpr double kJoint_m = 0.02;  ///< between a slab and its house, so that they do not overlap

/// Places houses where they fit: dry, level enough, clear of roads and of each other.
class Plots {
public:
    Plots(const Terrain& terrain, const std::vector<Road>& roads, std::vector<Building> taken)
        : m_terrain(terrain), m_roads(roads), m_buildings(std::move(taken)) {}

    /// @param eaves_m, ridge_m above the highest ground at the footprint
    /// @return false when it does not fit
    bool add(Building building, double eaves_m, double ridge_m) {
        if (!clear_of_others(building) || !clear_of_roads(building))
            return false;
        const auto ground = measure_ground(building.corners(0.5), kMaxSlope_m);
        if (!ground)
            return false;
        building.ground_m = ground->first;
        building.eaves_m = ground->second + eaves_m;
        building.ridge_m = ground->second + ridge_m;
        m_buildings.push_back(building);
        return true;
    }
    /// A slab that touches the building `host` and nothing else.
    /// @param underside_m above the highest ground beneath
    bool add_slab(Building slab, std::size_t host, double underside_m, double thickness_m) {
        Building others = slab;
        others.half_length_m += kNeighbourGap_m;
        others.half_width_m += kNeighbourGap_m;
        for (std::size_t i = 0; i < m_buildings.size(); ++i)
            if (length(m_buildings[i].centre - slab.centre) < 60.0 &&
                footprints_overlap(m_buildings[i], i == host ? slab : others, 0))
                return false;
        if (!clear_of_roads(slab))
            return false;
        const auto ground = measure_ground(slab.corners(), kMaxSlabSlope_m);
        if (!ground)
            return false;
        slab.ground_m = ground->first;
        slab.underside_m = ground->second + underside_m;
        slab.eaves_m = slab.ridge_m = slab.underside_m + thickness_m;
        m_buildings.push_back(slab);
        return true;
    }
    [[nodiscard]] const std::vector<Building>& buildings() const noexcept { return m_buildings; }
    [[nodiscard]] std::vector<Building> take() { return std::move(m_buildings); }

private:
    /// The lowest and the highest ground at some places; nullopt where it is wet or too steep.
    [[nodiscard]] std::optional<std::pair<double, double>> measure_ground(
        const std::array<Vec2, 4>& places, double max_slope_m) const {
        double low = 1e9;
        double high = -1e9;
        for (const Vec2 p : places) {
            const TerrainSpot spot = m_terrain.at(p);
            if (spot.water_m > kNoWater)
                return std::nullopt;
            low = std::min(low, spot.ground_m);
            high = std::max(high, spot.ground_m);
        }
        return high - low > max_slope_m ? std::nullopt : std::optional(std::pair(low, high));
    }
    [[nodiscard]] bool clear_of_others(const Building& building) const {
        return std::none_of(m_buildings.begin(), m_buildings.end(), [&](const Building& other) {
            return length(other.centre - building.centre) < 60.0 &&
                   footprints_overlap(other, building, kNeighbourGap_m);
        });
    }
    [[nodiscard]] bool clear_of_roads(const Building& building) const {
        const double reach = building.half_length_m + building.half_width_m;
        for (const Road& road : m_roads)
            for (const auto& vertex : road.line) {
                if (length(vertex.at - building.centre) >
                    reach + road.half_width_m + kRoadClearance_m)
                    continue;
                Building widened = building;
                const double margin = road.half_width_m + kRoadClearance_m;
                widened.half_length_m += margin;
                widened.half_width_m += margin;
                widened.roof = RoofType::kFlat;
                if (widened.top_m(vertex.at))
                    return false;
            }
        return true;
    }

    const Terrain& m_terrain;
    const std::vector<Road>& m_roads;
    std::vector<Building> m_buildings;
};

struct Style {
    RoofType roof;
    RoofColour colour;
};

Style choose_style(Random& random) {
    const double dice = random.unit();
    if (dice < 0.54)
        return {RoofType::kGable, RoofColour::kRed};
    if (dice < 0.66)
        return {RoofType::kHip, RoofColour::kRed};
    if (dice < 0.88)
        return {RoofType::kGable, RoofColour::kGrey};
    return {RoofType::kFlat, RoofColour::kPale};
}

// A house, perhaps with a wing at a right angle, and perhaps a shed behind it.
void add_house(Random random, Vec2 kerb, Vec2 along, Vec2 outward, Plots& plots) {
    const Style style = choose_style(random);
    const bool gable_to_street = random.chance(0.35);
    Building house;
    house.half_length_m = random.range(4.8, 7.4);
    house.half_width_m = random.range(3.7, 4.9);
    house.roof = style.roof;
    house.colour = style.colour;
    house.tint = static_cast<std::uint32_t>(random.next());
    const Vec2 turned = unit(along + turn_left(along) * random.range(-0.07, 0.07));
    house.direction = gable_to_street ? turn_left(turned) : turned;
    const double depth = gable_to_street ? house.half_length_m : house.half_width_m;
    house.centre = kerb + outward * (depth + random.range(3.0, 7.5));
    const double eaves = random.chance(0.6) ? random.range(5.2, 6.3) : random.range(3.2, 4.2);
    const double rise =
        style.roof == RoofType::kFlat ? 0.0 : house.half_width_m * random.range(0.72, 0.95);
    if (!plots.add(house, eaves, eaves + rise))
        return;
    if (style.roof == RoofType::kGable && random.chance(0.35)) {
        Building wing = house;
        wing.half_length_m = random.range(2.5, 3.8);
        wing.half_width_m = house.half_width_m * 0.75;
        wing.direction = turn_left(house.direction);
        const double side = random.chance(0.5) ? 1.0 : -1.0;
        wing.centre = house.centre +
                      wing.direction *
                          (side * (house.half_width_m + wing.half_length_m + 2 * kNeighbourGap_m)) +
                      house.direction * random.range(-2.0, 2.0);
        // Tested at a distance from the house, then moved against it: a wing touches its house and
        // nothing else.
        if (plots.add(wing, eaves * 0.9, eaves * 0.9 + rise * 0.75))
            return;
    }
    Building shed = house;
    shed.use = BuildingUse::kShed;
    shed.roof = RoofType::kGable;
    shed.colour = random.chance(0.5) ? RoofColour::kGrey : RoofColour::kRed;
    shed.half_length_m = random.range(2.4, 3.6);
    shed.half_width_m = random.range(1.8, 2.6);
    shed.centre = kerb + outward * random.range(19.0, 25.0) + along * random.range(-5.0, 5.0);
    if (random.chance(0.4))
        plots.add(shed, 2.3, 3.9);
}

// A farm: a long house and a barn around a yard.
void add_farm(Random random, Vec2 kerb, Vec2 along, Vec2 outward, Plots& plots) {
    Building barn;
    barn.use = BuildingUse::kFarm;
    barn.tint = static_cast<std::uint32_t>(random.next());
    barn.direction = outward;
    barn.half_length_m = random.range(9, 13);
    barn.half_width_m = random.range(5, 6.5);
    barn.centre = kerb + outward * (barn.half_length_m + 8.0) + along * 14.0;
    barn.colour = random.chance(0.5) ? RoofColour::kGrey : RoofColour::kRed;
    plots.add(barn, 5.0, 9.5);
    Building house = barn;
    house.direction = along;
    house.half_length_m = 7.5;
    house.half_width_m = 4.8;
    house.colour = RoofColour::kRed;
    house.centre = kerb + outward * 12.0 - along * 8.0;
    plots.add(house, 5.6, 9.6);
}

// A balcony along a long side of a house of two storeys, or a carport against its end; some houses
// have neither. Added after all houses, with separate random numbers, so that they do not affect
// where houses stand.
void add_overhangs(std::uint64_t seed, std::size_t landmarks, Plots& plots) {
    const std::size_t houses = plots.buildings().size();
    for (std::size_t i = landmarks; i < houses; ++i) {
        const Building house = plots.buildings()[i];
        Random random(compute_hash(seed, 0x0BA1, i));
        const double dice = random.unit();
        const double side = random.chance(0.5) ? 1.0 : -1.0;
        if (house.use != BuildingUse::kHouse)
            continue;
        Building slab;
        slab.roof = RoofType::kFlat;
        slab.colour = RoofColour::kPale;
        slab.tint = static_cast<std::uint32_t>(random.next());
        slab.direction = house.direction;
        if (dice < 0.25 && house.eaves_m - house.ground_m > kStorey_m + 1.5) {
            slab.use = BuildingUse::kBalcony;
            slab.half_length_m = 0.7 * house.half_length_m;
            slab.half_width_m = random.range(0.9, 1.3);
            slab.centre =
                house.centre + turn_left(house.direction) *
                                   (side * (house.half_width_m + slab.half_width_m + kJoint_m));
            plots.add_slab(slab, i, kStorey_m, 0.25);
        } else if (dice > 0.7) {
            slab.use = BuildingUse::kCarport;
            slab.colour = RoofColour::kGrey;
            slab.half_length_m = random.range(1.6, 2.8);
            slab.half_width_m = random.range(2.6, 3.2);
            slab.centre =
                house.centre +
                house.direction * (side * (house.half_length_m + slab.half_length_m + kJoint_m));
            plots.add_slab(slab, i, kStorey_m, 0.3);
        }
    }
}

void line_street(const Street& street, const Road& road, std::uint64_t seed, Plots& plots) {
    const auto vertices = static_cast<double>(road.line.size());
    for (const double side : {1.0, -1.0}) {
        Random random(compute_hash(seed, side > 0 ? 1 : 2));
        double at = street.houses_from * vertices + random.range(2.0, 4.0);
        for (; at < street.houses_to * vertices - 2.0;
             at += random.range(0.85, 1.25) * street.house_step_m / kRoadStep_m) {
            const auto i = static_cast<std::size_t>(at);
            if (i + 1 >= road.line.size() || road.line[i].on_bridge)
                continue;
            const Vec2 along = unit(road.line[i + 1].at - road.line[i].at);
            const Vec2 outward = turn_left(along) * side;
            const Vec2 kerb = road.line[i].at + outward * road.half_width_m;
            const Random house(random.next());
            if (street.house_step_m >= kFarmStep_m)
                add_farm(house, kerb, along, outward, plots);
            else
                add_house(house, kerb, along, outward, plots);
        }
    }
}

}  // namespace

std::vector<Building> build_village(const Terrain& terrain, const Site& site) {
    const Box2 around{site.centre.x, site.centre.y, site.centre.x, site.centre.y};
    const RoadNet streets = build_streets(terrain, site);
    const RoadNet roads = build_roads(terrain, around.expanded(450));
    std::vector<Building> landmarks = build_landmarks(terrain, site);
    const std::size_t landmark_count = landmarks.size();
    Plots plots(terrain, roads.roads, std::move(landmarks));
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < site.streets.size() && i < streets.roads.size(); ++i, ++number)
        if (site.streets[i].house_step_m > 0)
            line_street(site.streets[i], streets.roads[i], compute_hash(site.seed, 0x57, number),
                        plots);
    add_overhangs(site.seed, landmark_count, plots);
    return plots.take();
}

}  // namespace terravox::survey
