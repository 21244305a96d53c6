#include <algorithm>
#include <cmath>

#include "tests/catch.hpp"
#include "tests/voxelserver/data/water/landscapes.hpp"
#include "voxelserver/data/water/body_levels.hpp"
#include "voxelserver/data/water/river.hpp"

using namespace terravox::water;
using namespace terravox::water::test;

namespace {

constexpr double kClose_m = 0.3;

// The water of a landscape as one body. `unseen` cells around a place are a bridge: nothing was
// seen of the water below.
Body scanned(Landscape& land, Landscape::Place bridge, double unseen, double noise_m) {
    const std::vector<WaterCell> seen = land.scan(noise_m, 0);
    Body body;
    for (int z = 0; z < land.height(); ++z)
        for (int x = 0; x < land.width(); ++x) {
            if (std::isnan(land.truth(x, z)))
                continue;
            const WaterCell& c = seen[land.index(x, z)];
            const bool hidden = std::hypot(x - bridge.x, z - bridge.z) < unseen;
            body.places.push_back({x, z});
            body.samples.push_back(c.water_points > 0 && !hidden
                                       ? LevelSample{c.water, c.water_points}
                                       : LevelSample{});
        }
    return body;
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
