#include "raytracer/apps/pmtiles/web_area.hpp"

#include <cstdlib>
#include <map>

#include "tests/catch.hpp"

using namespace terravox;

TEST_CASE("tiles have the numbers of the format", "[pmtiles]") {
    struct Case {
        pmtiles::TileAddress tile;
        std::uint64_t id;
    };
    // The last four as other programs count.
    const auto [tile, id] =
        GENERATE(Case{{0, 0, 0}, 0}, Case{{1, 0, 0}, 1}, Case{{1, 0, 1}, 2}, Case{{1, 1, 1}, 3},
                 Case{{1, 1, 0}, 4}, Case{{2, 0, 0}, 5}, Case{{3, 5, 2}, 76},
                 Case{{12, 3423, 1763}, 19'078'479}, Case{{18, 141'650, 93'217}, 81'192'317'692},
                 Case{{26, (1U << 26) - 1, 0}, 6'004'799'503'160'660});
    CHECK(pmtiles::tile_id(tile) == id);
}
