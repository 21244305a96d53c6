#include <algorithm>
#include <cmath>

#include "tests/catch.hpp"
#include "tests/voxelserver/data/water/landscapes.hpp"
#include "voxelserver/data/water/body_levels.hpp"
#include "voxelserver/data/water/river.hpp"

using namespace terravox::water;
using namespace terravox::water::test;

namespace {

// A landscape's water as one body, its levels, and ways to look at them by place.
class Levelled {
public:
    explicit Levelled(Landscape& land, double noise_m = 0.04, double strays = 0.03,
                      const LevelOptions& options = {})
        : m_land(land) {
        const std::vector<WaterCell> seen = land.scan(noise_m, strays);
        m_body = make_body(land, seen, [](int, int) { return false; });
        m_level.assign(seen.size(), kNoLevel);
        const std::vector<float> levels = body_levels(m_body, options);
        for (std::size_t i = 0; i < levels.size(); ++i)
            m_level[land.index(m_body.places[i].x, m_body.places[i].z)] = levels[i];
    }
    [[nodiscard]] float at(std::int32_t x, std::int32_t z) const {
        return m_land.inside(x, z) ? m_level[m_land.index(x, z)] : kNoLevel;
    }
    [[nodiscard]] const Body& body() const { return m_body; }

    [[nodiscard]] double rmse() const {
        double sum = 0;
        for (const CellPlace p : m_body.places) {
            const double error =
                static_cast<double>(at(p.x, p.z)) - static_cast<double>(m_land.truth(p.x, p.z));
            sum += error * error;
        }
        return std::sqrt(sum / static_cast<double>(m_body.places.size()));
    }

    // The most that the level rises from one place of a course to a later one; every sixth cell,
    // for a course drawn in cells goes to and fro over the edge between two cross-sections. Its
    // last cells are left out: a river's end is drawn round and level.
    // @param from first cell looked at: where arms part, cross-sections of one reach into the other
    [[nodiscard]] double rise_along(const std::vector<std::pair<int, int>>& course,
                                    std::size_t from = 0) const {
        double lowest = 1e9;
        double rise = 0;
        for (std::size_t i = from; i + 12 < course.size(); i += 6) {
            const auto [x, z] = course[i];
            if (std::isnan(at(x, z)))
                continue;
            rise = std::max(rise, static_cast<double>(at(x, z)) - lowest);
            lowest = std::min(lowest, static_cast<double>(at(x, z)));
        }
        return rise;
    }

private:
    Landscape& m_land;
    Body m_body;
    std::vector<float> m_level;
};

constexpr double kClose_m = 0.3;

// The water of a landscape as one body. `unseen` cells around a place are a bridge: nothing was
// seen of the water below.
Body scanned(Landscape& land, Landscape::Place bridge, double unseen, double noise_m) {
    return make_body(land, land.scan(noise_m, 0),
                     [&](int x, int z) { return std::hypot(x - bridge.x, z - bridge.z) < unseen; });
}

// The levels of a body, section by section, next to what was seen of each.
class Sectioned {
public:
    explicit Sectioned(const Body& body)
        : m_adjacency(body.places),
          m_sections(make_sections(m_adjacency, LevelOptions{}.cell_m)),
          m_seen(section_samples(m_sections, body.samples, 0, 1)),
          m_level(m_seen.size()),
          m_excess(m_seen.size()) {
        const std::vector<float> levels = body_levels(body, m_adjacency, {});
        for (std::size_t i = 0; i < levels.size(); ++i)
            m_level[static_cast<std::size_t>(m_sections.section_of[i])] =
                static_cast<double>(levels[i]);
        find_excess();
    }
    // How far the worst section with returns is from their median, beyond what no falling water
    // could be nearer to.
    [[nodiscard]] double farthest() const {
        double out = 0;
        for (std::size_t s = 0; s < m_seen.size(); ++s)
            if (m_seen[s].weight > 0)
                out = std::max(out, std::abs(m_level[s] - m_seen[s].level_m) - m_excess[s]);
        return out;
    }
    [[nodiscard]] std::ptrdiff_t free_sections() const {
        std::ptrdiff_t out = 0;
        for (std::size_t s = 0; s < m_seen.size(); ++s)
            out += m_seen[s].weight > 0 && m_excess[s] < 0.1 ? 1 : 0;
        return out;
    }

private:
    // By how much a median is above the lowest one upstream of it, or below the highest one
    // downstream.
    void find_excess() {
        const Drainage d = drain(m_sections, m_level, kClose_m);
        std::vector<double> below(m_seen.size(), -1e9), above(m_seen.size(), 1e9);
        const auto parent = [&](std::size_t s) { return static_cast<std::size_t>(d.parent[s]); };
        for (const std::int32_t section : d.order) {
            const auto s = static_cast<std::size_t>(section);
            if (d.parent[s] != Adjacency::kNone)
                below[s] = below[parent(s)];
            if (m_seen[s].weight > 0) {
                m_excess[s] = std::max(0.0, below[s] - m_seen[s].level_m);
                below[s] = std::max(below[s], m_seen[s].level_m);
            }
        }
        for (std::size_t k = d.order.size(); k-- > 0;) {
            const auto s = static_cast<std::size_t>(d.order[k]);
            if (m_seen[s].weight > 0) {
                m_excess[s] = std::max(m_excess[s], m_seen[s].level_m - above[s]);
                above[s] = std::min(above[s], m_seen[s].level_m);
            }
            if (d.parent[s] != Adjacency::kNone)
                above[parent(s)] = std::min(above[parent(s)], above[s]);
        }
    }

    Adjacency m_adjacency;
    RiverSections m_sections;
    std::vector<SectionSample> m_seen;
    std::vector<double> m_level;
    std::vector<double> m_excess;
};

}  // namespace

TEST_CASE("a noisy lake has exactly one level, within 5 cm of the truth", "[water][levels]") {
    const auto seed = GENERATE(range(1u, 6u));
    Landscape land(120, 110, seed);
    land.lake({60, 55}, 50, 475.98);
    land.island({40, 60}, 9);
    const Levelled found(land, 0.05, 0.05);
    INFO("seed " << seed);
    const float level = found.at(60, 50);
    CHECK(std::abs(static_cast<double>(level) - 475.98) < 0.05);
    for (const CellPlace p : found.body().places)
        REQUIRE(found.at(p.x, p.z) == level);
}

TEST_CASE("a river with bends, an island and a tributary falls on every way down",
          "[water][levels]") {
    struct Case {
        const char* name;
        double slope_per_cell;
        double radius;
    };
    const auto c = GENERATE(values<Case>({
        {"0.1 %", 0.002, 8},
        {"0.5 %", 0.01, 6},
        {"1 %", 0.02, 8},
        {"3 %", 0.06, 4},
    }));
    const auto seed = GENERATE(range(1u, 3u));
    DYNAMIC_SECTION(c.name << ", seed " << seed) {
        Landscape land(700, 260, seed);
        const auto course = land.river(wave(5, 690, 150, 60, 300), c.radius, 100, c.slope_per_cell);
        const auto mouth = course[course.size() * 6 / 10];
        const double mouth_level = static_cast<double>(land.truth(mouth.first, mouth.second));
        const Landscape::Place spring{static_cast<double>(mouth.first) - 60,
                                      mouth.second > 150 ? 5.0 : 255.0};
        const double way = std::hypot(spring.x - mouth.first, spring.z - mouth.second);
        const auto side =
            land.river(line(spring, {mouth.first + 0.5, mouth.second + 0.5}), 3,
                       mouth_level + way * c.slope_per_cell * 2, c.slope_per_cell * 2);
        land.island({wave(5, 690, 150, 60, 300)[3000].x, wave(5, 690, 150, 60, 300)[3000].z},
                    c.radius * 0.5);
        const Levelled found(land);
        INFO("RMSE " << found.rmse() << " m over " << found.body().places.size() << " cells");
        CHECK(found.rmse() < 0.1);
        CHECK(found.rise_along(course) == 0);
        CHECK(found.rise_along(side) == 0);
    }
}

TEST_CASE("a river is level from bank to bank", "[water][levels]") {
    Landscape land(400, 60, 3);
    land.river(line({5, 30}, {395, 30}), 10, 50, 0.02);
    const Levelled found(land);
    double widest = 0;
    for (int x = 30; x < 370; ++x)
        widest = std::max(widest, std::abs(static_cast<double>(found.at(x, 22)) -
                                           static_cast<double>(found.at(x, 38))));
    CHECK(widest < 0.15);  // 32 m apart where the river falls 1 %: three cross-sections, for
                           // distances are not quite Euclidean
}

TEST_CASE("both arms around a long island fall, though one is far longer", "[water][levels]") {
    const auto seed = GENERATE(range(1u, 4u));
    Landscape land(500, 200, seed);
    const double slope = 0.02;
    auto course = land.river(line({5, 150}, {120, 150}), 5, 80, slope);
    const double split = 80 - 115 * slope;
    auto straight = land.river(line({120, 150}, {380, 150}), 5, split, slope);
    const double joined = split - 260 * slope;
    std::vector<Landscape::Place> detour;
    for (const auto& part :
         {line({120, 150}, {150, 30}), line({150, 30}, {350, 30}), line({350, 30}, {380, 150})})
        detour.insert(detour.end(), part.begin(), part.end());
    const double detour_way = 2 * std::hypot(30, 120) + 200;
    auto longer = land.river(detour, 4, split, (split - joined) / detour_way);
    auto rest = land.river(line({380, 150}, {495, 150}), 5, joined, slope);
    const Levelled found(land);
    INFO("seed " << seed << ", RMSE " << found.rmse());
    CHECK(found.rmse() < 0.1);
    CHECK(found.rise_along(straight) == 0);
    CHECK(found.rise_along(longer, 24) == 0);
    CHECK(found.rise_along(rest, 24) == 0);
}

TEST_CASE("a lake inside a river is flat, the river above and below it falls", "[water][levels]") {
    const auto seed = GENERATE(range(1u, 4u));
    Landscape land(900, 220, seed);
    const auto above = land.river(line({5, 110}, {300, 110}), 5, 106, 0.02);
    const auto below = land.river(line({500, 110}, {895, 110}), 5, 99.98, 0.02);
    land.lake({400, 110}, 100, 99.98);
    const Levelled found(land, 0.05, 0.05);
    INFO("seed " << seed << ", RMSE " << found.rmse());
    CHECK(found.rmse() < 0.1);
    const float level = found.at(400, 110);
    CHECK(std::abs(static_cast<double>(level) - 99.98) < 0.05);
    std::size_t cells = 0;
    std::size_t flat = 0;
    for (const CellPlace p : found.body().places) {
        if (std::hypot(p.x - 400, p.z - 110) > 95)
            continue;
        ++cells;
        flat += found.at(p.x, p.z) == level ? 1 : 0;
    }
    CHECK(cells > 25000);
    CHECK(flat == cells);
    CHECK(found.rise_along(above) == 0);
    CHECK(found.rise_along(below) == 0);
    CHECK(found.at(10, 110) > 105.7f);
    CHECK(found.at(890, 110) < 92.5f);
}

TEST_CASE("few returns never lift a lake above its low shore", "[water][levels]") {
    Body body;
    for (int i = 0; i < 30; ++i) {
        body.places.push_back({i, 0});
        body.samples.push_back({});
    }
    struct Case {
        const char* name;
        std::vector<LevelSample> seen;
        std::vector<float> shore;
        float level;
    };
    const auto c = GENERATE(values<Case>({
        {"nothing seen, shore only", {}, {5, 5.1f, 5.2f, 5.3f, 6, 7, 8, 9, 9, 9}, 5.1f},
        {"three returns below the shore", {{4.5f, 3}}, {5, 5.1f, 5.2f}, 4.5f},
        {"three returns in the reeds", {{5.6f, 3}}, {5, 5.1f, 5.2f}, 5},
        {"many returns above low ground outside a dike", {{5.6f, 40}}, {3, 3, 6}, 5.6f},
        {"returns and no shore", {{5.6f, 2}}, {}, 5.6f},
        {"nothing seen and no shore", {}, {}, kNoLevel},
    }));
    DYNAMIC_SECTION(c.name) {
        for (std::size_t i = 0; i < c.seen.size(); ++i)
            body.samples[i] = c.seen[i];
        body.shore = c.shore;
        for (const float level : body_levels(body, {}))
            REQUIRE((level == c.level || (std::isnan(level) && std::isnan(c.level))));
    }
}

TEST_CASE("without equalization cells keep what was seen in them", "[water][levels]") {
    Body body;
    for (int i = 0; i < 6; ++i) {
        body.places.push_back({i, 0});
        body.samples.push_back({});
    }
    body.samples[1] = {3, 1};
    body.samples[5] = {4, 2};
    CHECK(body_levels(body, {2, 1, false}) == std::vector<float>{3, 3, 3, 3, 4, 4});
    CHECK(body_levels({}, {}).empty());
}

TEST_CASE("a brook that runs into a lake falls to it, and the lake stays flat", "[water][levels]") {
    struct Case {
        const char* name;
        double fall;
    };
    const auto c = GENERATE(values<Case>({{"1 %", 0.02}, {"2.5 %", 0.05}, {"10 %", 0.2}}));
    const auto seed = GENERATE(range(1u, 4u));
    DYNAMIC_SECTION(c.name << ", seed " << seed) {
        Landscape land(220, 130, seed);
        land.river(line({216, 65}, {125, 65}), 1.2, 475 + 5 * c.fall + 86 * c.fall, c.fall);
        land.lake({65, 65}, 60, 475);
        const Body body = scanned(land, {160, 65}, 3, 0.04);
        const std::vector<float> levels = body_levels(body, {});
        std::set<float> lake;
        for (std::size_t i = 0; i < levels.size(); ++i)
            if (body.places[i].x < 110)
                lake.insert(levels[i]);
        CHECK(lake.size() == 1);
        CHECK(std::abs(static_cast<double>(*lake.begin()) - 475) < 0.05);
        CHECK(Sectioned(body).farthest() < kClose_m);
    }
}

TEST_CASE(
    "where a river shows returns it stands within 0.3 m of their median, unless water would have "
    "to run uphill",
    "[water][levels]") {
    const auto seed = GENERATE(range(1u, 41u));
    Landscape land(420, 200, seed);
    const double slope = 0.03 * land.uniform() * land.uniform();
    const double top = 400 + 100 * land.uniform();
    const double weir_x = 40 + 340 * land.uniform();
    const double weir = seed % 3 == 0 ? 0.5 + 2 * land.uniform() : 0;
    land.river(line({weir_x, 100}, {418, 100}), 2 + 5 * land.uniform(), top - weir_x * slope - weir,
               slope);
    land.river(line({2, 100}, {weir_x, 100}), 2 + 5 * land.uniform(), top, slope);
    const int brooks = 1 + static_cast<int>(land.uniform() * 3);
    Landscape::Place bridge{0, 0};
    for (int k = 0; k < brooks; ++k) {
        const double mouth_x = 70 + 110 * k;
        const double fall = 0.01 + 0.19 * land.uniform();
        const double dx = -60 * land.uniform();
        const double dz = (k % 2 == 0 ? -1 : 1) * (40 + 50 * land.uniform());
        const double mouth = top - mouth_x * slope - (mouth_x > weir_x ? weir : 0);
        land.river(line({mouth_x + dx, 100 + dz}, {mouth_x, 100}), 1 + land.uniform(),
                   mouth + std::hypot(dx, dz) * fall, fall);
        bridge = {mouth_x + dx / 2, 100 + dz / 2};
    }
    const Body body = scanned(land, bridge, 2 + 4 * land.uniform(), 0.05);
    const Sectioned found(body);
    INFO("seed " << seed << ", river falls " << slope << " a cell, weir of " << weir << " m, "
                 << brooks << " brooks");
    CHECK(found.free_sections() > 80);
    CHECK(found.farthest() < kClose_m);
}
