#include "voxelserver/tools/survey/terrain.hpp"

#include "voxelserver/tools/survey/randomness.hpp"

namespace terravox::survey {
namespace {

// A point of the manually made plan, metres from the south-west corner of the square TM_462_101.
constexpr Vec2 plan(double east, double north) noexcept {
    return {east - 500.0, north - 500.0};
}

// The brook leaves the lake at its south-east shore and falls to the river.
Brook outlet_of_the_place(const River& river) {
    const double mouth_x = plan(640, 0).x;
    const std::vector<Vec2> way = {plan(560, 455), plan(590, 425),
                                   plan(607, 398), plan(618, 366),
                                   plan(632, 325), {mouth_x, river.centre_y(mouth_x)}};
    const double end_m = river.level_m(mouth_x);
    Brook brook;
    brook.half_width_m = 3.0;
    for (std::size_t i = 0; i < way.size(); ++i) {
        const double fall =
            i < 2 ? 0.0 : static_cast<double>(i - 1) / static_cast<double>(way.size() - 2);
        brook.line.push_back({way[i], lerp(kLakeLevel_m, end_m, fall)});
    }
    return brook;
}

std::vector<Street> streets_of_the_place(const Lake& lake, Vec2 castle_gate) {
    const auto asphalt = RoadSurface::kAsphalt;
    const auto gravel = RoadSurface::kGravel;
    const auto behind_hotels = [&](double east, double north) {
        const Vec2 direction = unit({east, north});
        return lake.shore_point(direction) + direction * 38.0;
    };
    return {
        {{plan(630, -80), plan(645, 100), plan(658, 200), plan(664, 250), plan(668, 310),
          plan(684, 400), plan(702, 480), plan(706, 560), plan(716, 640), plan(770, 720),
          plan(830, 800), plan(870, 900), plan(960, 1010), plan(1010, 1120)},
         3.6,
         asphalt,
         17,
         0.36,
         0.66},
        {{plan(702, 480), plan(760, 500), plan(850, 494), plan(930, 520), plan(985, 560)},
         2.6,
         asphalt,
         19,
         0,
         1},
        {{plan(684, 400), plan(760, 402), plan(860, 388), plan(950, 384)}, 2.6, asphalt, 18, 0, 1},
        {{plan(760, 402), plan(768, 500), plan(772, 590), plan(800, 660)},
         2.3,
         asphalt,
         18,
         0,
         0.85},
        {{plan(850, 494), plan(862, 388), plan(864, 345)}, 2.3, asphalt, 18, 0, 1},
        {{plan(706, 560), plan(772, 590), plan(860, 588), plan(920, 620)}, 2.3, asphalt, 20, 0, 1},
        {{plan(684, 400), behind_hotels(1, -0.4), behind_hotels(1, -0.1), behind_hotels(1, 0.15),
          behind_hotels(1, 0.45), plan(706, 560)},
         2.3,
         asphalt,
         24,
         0.1,
         1},
        {{plan(714, 630), plan(700, 690), plan(690, 750), plan(655, 800), plan(600, 815),
          plan(560, 780), castle_gate + Vec2{14, 34}, castle_gate + Vec2{0, 10},
          castle_gate + Vec2{0, -14}},
         1.8,
         gravel,
         0,
         0,
         1},
        {{plan(350, 350), plan(300, 250), plan(270, 120), plan(210, 40), plan(150, -60)},
         1.6,
         gravel,
         0,
         0,
         1},
        {{plan(652, 150), plan(760, 150), plan(880, 120), plan(1060, 130)},
         1.6,
         gravel,
         70,
         0.3,
         0.9},
    };
}

Site the_place(std::uint64_t seed, const River& river) {
    Site site;
    site.seed = compute_hash(seed, 0x5173);
    site.centre = plan(740, 450);
    site.lake = Lake{plan(425, 540), 170, 122, kLakeLevel_m, 14, compute_hash(seed, 0x1A4E)};
    site.island = Mound{plan(388, 522), 42, 31, kLakeLevel_m + 7.5};
    const Vec2 to_castle = unit({0.5, 1.0});
    site.castle =
        Mound{site.lake->shore_point(to_castle) + to_castle * 45.0, 43, 32, kLakeLevel_m + 76};
    site.brook = outlet_of_the_place(river);
    site.hills = {{plan(60, 690), 310, 140}, {plan(270, 1010), 400, 175},
                  {plan(545, 880), 235, 82}, {plan(830, 1010), 320, 95},
                  {plan(15, 470), 150, 40},  {plan(1000, 760), 180, 40}};
    site.streets = streets_of_the_place(*site.lake, site.castle->centre + Vec2{5, 26});
    site.church = plan(733, 447);
    site.church_direction = unit({1.0, 0.12});
    return site;
}

std::vector<Street> streets_of_a_village(Random& random, Vec2 centre, double river_y,
                                         double mirror) {
    const double bend = random.range(-35, 35);
    const auto at = [&](double east, double north) {
        return Vec2{centre.x + mirror * east, centre.y + north};
    };
    const Vec2 crossing{centre.x, river_y};
    std::vector<Street> streets;
    streets.push_back({{crossing + Vec2{bend, -420}, crossing + Vec2{0, -160},
                        crossing + Vec2{0, -30}, crossing + Vec2{0, 30}, at(0, 0), at(bend, 110),
                        at(0.5 * bend, 230), at(40, 420), at(20, 620)},
                       3.0,
                       RoadSurface::kAsphalt,
                       18,
                       0.42,
                       0.78});
    const int lanes = 2 + static_cast<int>(random.next() % 3);
    for (int i = 0; i < lanes; ++i) {
        const double north = 75.0 + 72.0 * i;
        const double east = random.range(110, 230);
        const double west = -random.range(60, 200);
        streets.push_back(
            {{at(west, north + random.range(-25, 25)), at(0.5 * west, north + random.range(-9, 9)),
              at(bend * 0.7, north), at(0.5 * east, north + random.range(-14, 14)),
              at(east, north + random.range(-30, 30))},
             2.3,
             RoadSurface::kAsphalt,
             random.range(18, 24),
             0,
             1});
    }
    streets.push_back({{at(230, 75), at(300, 180), at(380, 330), at(420, 520)},
                       1.6,
                       RoadSurface::kGravel,
                       90,
                       0.2,
                       0.9});
    return streets;
}

Site a_village(std::uint64_t seed, std::int64_t along, const River& river) {
    Site site;
    site.seed = compute_hash(seed, 0x5174, along, river.index());
    Random random(site.seed);
    const double x = static_cast<double>(along) * kSiteSpacing_m + random.range(-220, 220);
    const double river_y = river.centre_y(x);
    const double mirror = random.chance(0.5) ? 1.0 : -1.0;
    site.centre = {x, river_y + valley_road_offset_m(x, river.index())};
    site.streets = streets_of_a_village(random, site.centre, river_y, mirror);
    site.church = site.centre + Vec2{mirror * 30.0, 38.0};
    site.church_direction = unit({1.0, random.range(-0.3, 0.3)});
    if (random.chance(0.45)) {
        const Vec2 middle =
            site.centre + Vec2{-mirror * random.range(380, 430), random.range(150, 260)};
        site.lake = Lake{middle,
                         random.range(85, 145),
                         random.range(70, 110),
                         river.level_m(middle.x) + random.range(4.5, 7.0),
                         9,
                         random.next()};
    }
    return site;
}

}  // namespace

double valley_road_offset_m(double x, std::int64_t river) noexcept {
    return river == 0 ? lerp(72.0, 95.0, smoothstep(600.0, 900.0, std::abs(x))) : 95.0;
}

std::vector<Site> sites_near(std::uint64_t seed, const Box2& area) {
    const auto first_river = static_cast<std::int64_t>(std::floor(
                                 (area.y0 - kSiteReach_m - kRiverSway_m) / kRiverSpacing_m)) -
                             1;
    const auto last_river = static_cast<std::int64_t>(std::floor(
                                (area.y1 + kSiteReach_m + kRiverSway_m) / kRiverSpacing_m)) +
                            1;
    const auto first =
        static_cast<std::int64_t>(std::floor((area.x0 - kSiteReach_m) / kSiteSpacing_m)) - 1;
    const auto last =
        static_cast<std::int64_t>(std::floor((area.x1 + kSiteReach_m) / kSiteSpacing_m)) + 1;
    std::vector<Site> sites;
    for (auto m = first_river; m <= last_river; ++m) {
        const River river(seed, m);
        for (auto k = first; k <= last; ++k) {
            Site site = k == 0 && m == 0 ? the_place(seed, river) : a_village(seed, k, river);
            site.along = k;
            site.river = m;
            if (area.expanded(kSiteReach_m).contains(site.centre))
                sites.push_back(std::move(site));
        }
    }
    return sites;
}

}  // namespace terravox::survey
