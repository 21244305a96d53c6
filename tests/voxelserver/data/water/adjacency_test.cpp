#include "voxelserver/data/water/water_cells.hpp"

#include <algorithm>
#include <random>

#include "tests/catch.hpp"

using namespace terravox::water;

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
