#include <algorithm>
#include <cmath>
#include <random>

#include "tests/catch.hpp"
#include "voxelserver/data/water/river.hpp"
#include "voxelserver/data/water/water_cells.hpp"

using namespace terravox::water;

namespace {

RiverSections graph(std::int32_t size,
                    const std::vector<std::pair<std::int32_t, std::int32_t>>& edges) {
    RiverSections out;
    out.length_m = 4;
    out.cells.assign(static_cast<std::size_t>(size), 1);
    out.begin.push_back(0);
    for (std::int32_t s = 0; s < size; ++s) {
        for (std::int32_t n = 0; n < size; ++n)
            for (const auto& [a, b] : edges)
                if ((a == s && b == n) || (a == n && b == s)) {
                    out.neighbours.push_back(n);
                    break;
                }
        out.begin.push_back(static_cast<std::uint32_t>(out.neighbours.size()));
        out.along_m.push_back(4.0 * s);
    }
    return out;
}

// A connected graph: a random tree and some edges more.
RiverSections random_graph(std::mt19937& random, std::int32_t size) {
    std::vector<std::pair<std::int32_t, std::int32_t>> edges;
    for (std::int32_t s = 1; s < size; ++s)
        edges.emplace_back(static_cast<std::int32_t>(random() % static_cast<unsigned>(s)), s);
    for (int k = 0; k < 4; ++k) {
        const auto a = static_cast<std::int32_t>(random() % static_cast<unsigned>(size));
        const auto b = static_cast<std::int32_t>(random() % static_cast<unsigned>(size));
        if (a != b)
            edges.emplace_back(a, b);
    }
    return graph(size, edges);
}

double objective(const std::vector<double>& x, const std::vector<double>& y,
                 const std::vector<double>& w) {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        sum += w[i] * (x[i] - y[i]) * (x[i] - y[i]);
    return sum;
}

}  // namespace

TEST_CASE("isotonic levels never fall upstream and nothing allowed is nearer to the data",
          "[water][drainage]") {
    const auto seed = GENERATE(range(1u, 60u));
    std::mt19937 random(seed);
    const std::int32_t size = 2 + static_cast<std::int32_t>(random() % 30);
    const RiverSections sections = random_graph(random, size);
    std::vector<double> y;
    std::vector<double> w;
    for (std::int32_t s = 0; s < size; ++s) {
        y.push_back(random() % 1000 / 100.0);
        w.push_back(1 + random() % 9);
    }
    const Drainage d = breadth_first(sections, 0);
    const std::vector<double> x = isotonic(d, y, w);
    INFO("seed " << seed);
    const auto allowed = [&](const std::vector<double>& v) {
        for (std::size_t s = 0; s < v.size(); ++s)
            if (d.parent[s] >= 0 && v[s] < v[static_cast<std::size_t>(d.parent[s])] - 1e-12)
                return false;
        return true;
    };
    REQUIRE(allowed(x));
    // The problem is convex: a better point would show in the direction of some feasible one.
    const double best = objective(x, y, w);
    for (int trial = 0; trial < 300; ++trial) {
        std::vector<double> other = x;
        const double by = (static_cast<int>(random() % 200) - 100) / 1000.0;
        const auto root = random() % x.size();
        const double at_root = x[root];
        for (const std::int32_t s :
             d.order) {  // moves a random connected piece of one level, or all of what lies above
            const auto i = static_cast<std::size_t>(s);
            if (i == root || (d.parent[i] >= 0 &&
                              other[static_cast<std::size_t>(d.parent[i])] !=
                                  x[static_cast<std::size_t>(d.parent[i])] &&
                              (trial % 2 == 0 || x[i] == at_root) && random() % 4 != 0))
                other[i] += by;
        }
        if (allowed(other))
            REQUIRE(objective(other, y, w) >= best - 1e-9);
    }
}

TEST_CASE("water runs off from every section", "[water][drainage]") {
    const auto seed = GENERATE(range(1u, 40u));
    std::mt19937 random(seed);
    const RiverSections sections = random_graph(random, 40);
    std::vector<double> levels;
    for (int s = 0; s < 40; ++s)
        levels.push_back(random() % 1000 / 100.0);
    const Drainage d = drain(sections, levels, 0.5);
    INFO("seed " << seed);
    REQUIRE(d.order.size() == 40);
    for (const bool raised : {false, true}) {
        std::vector<double> out = levels;
        if (raised)
            raise_to_lower(sections, d, out);
        else
            out = between_envelopes(sections, d, levels);
        for (std::int32_t s = 0; s < 40; ++s)
            sections.each_neighbour(s, [&](std::int32_t n) {
                const auto from = static_cast<std::size_t>(s);
                const auto to = static_cast<std::size_t>(n);
                if (d.rank[to] < d.rank[from])
                    REQUIRE(out[to] <= out[from]);
            });
    }
}

TEST_CASE("an end that lies well below the rim is an outlet of its own, a shallow hollow is not",
          "[water][drainage]") {
    const RiverSections chain = graph(5, {{0, 1}, {1, 2}, {2, 3}, {3, 4}});
    CHECK(drain(chain, {0, 1, 2, 1, 0.5}, 0.3).parent ==
          std::vector<std::int32_t>{-1, 0, 1, 4, -1});
    CHECK(drain(chain, {0, 1, 2, 1.9, 1.8}, 0.3).parent ==
          std::vector<std::int32_t>{-1, 0, 1, 2, 3});
}

TEST_CASE("adjacency agrees with looking for each neighbour in the list", "[water][adjacency]") {
    const auto seed = GENERATE(range(1u, 20u));
    std::mt19937 random(seed);
    const unsigned density = 1 + seed % 9;
    std::vector<CellPlace> places;
    for (std::int32_t z = -8; z < 8; ++z)
        for (std::int32_t x = -10; x < 7; ++x)
            if (random() % 10 < density)
                places.push_back({x, z});
    const Adjacency adjacency(places);
    REQUIRE(adjacency.size() == static_cast<std::int32_t>(places.size()));
    const auto index = [&](CellPlace p) {
        const auto found = std::find(places.begin(), places.end(), p);
        return found == places.end() ? Adjacency::kNone
                                     : static_cast<std::int32_t>(found - places.begin());
    };
    INFO("seed " << seed);
    for (std::int32_t i = 0; i < adjacency.size(); ++i) {
        const CellPlace p = places[static_cast<std::size_t>(i)];
        INFO("cell " << p.x << ", " << p.z);
        const std::int32_t w = index({p.x - 1, p.z});
        const std::int32_t e = index({p.x + 1, p.z});
        const std::int32_t n = index({p.x, p.z - 1});
        const std::int32_t s = index({p.x, p.z + 1});
        CHECK(adjacency.neighbour(i, kWest) == w);
        CHECK(adjacency.neighbour(i, kEast) == e);
        CHECK(adjacency.neighbour(i, kNorth) == n);
        CHECK(adjacency.neighbour(i, kSouth) == s);
        const bool corner = e != Adjacency::kNone || s != Adjacency::kNone;
        CHECK(adjacency.diagonal(i, kEast, kSouth) ==
              (corner ? index({p.x + 1, p.z + 1}) : Adjacency::kNone));
    }
}

TEST_CASE("parts are connected over edges, not corners, and numbered by their first cells",
          "[water][adjacency]") {
    // a a . b
    // . . b b
    // c . . b    with the middle b of the last column switched off
    const std::vector<CellPlace> places{{0, 0}, {1, 0}, {3, 0}, {2, 1}, {3, 1}, {0, 2}, {3, 2}};
    std::int32_t count = 0;
    CHECK(Adjacency(places).parts({1, 1, 1, 1, 1, 1, 1}, &count) ==
          std::vector<std::int32_t>{0, 0, 1, 1, 1, 2, 1});
    CHECK(count == 3);
    CHECK(Adjacency(places).parts({1, 1, 1, 1, 0, 1, 1}, &count) ==
          std::vector<std::int32_t>{0, 0, 1, 2, -1, 3, 4});
    CHECK(count == 5);
    CHECK(Adjacency({}).parts({}, &count).empty());
    CHECK(count == 0);
}
