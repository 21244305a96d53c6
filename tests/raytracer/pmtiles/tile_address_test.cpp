#include "raytracer/pmtiles/tile_address.hpp"

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

TEST_CASE("tiles of a zoom follow each other as neighbours, each once", "[pmtiles]") {
    const int zoom = GENERATE(1, 2, 3, 6);
    std::map<std::uint64_t, pmtiles::TileAddress> by_id;
    const std::uint32_t side = std::uint32_t{1} << zoom;
    for (std::uint32_t row = 0; row < side; ++row)
        for (std::uint32_t column = 0; column < side; ++column)
            by_id[pmtiles::tile_id({zoom, column, row})] = {zoom, column, row};
    REQUIRE(by_id.size() == std::size_t{side} * side);
    // Between those of the zoom before and the one behind.
    CHECK(by_id.begin()->first == (std::uint64_t{side} * side - 1) / 3);
    CHECK(by_id.rbegin()->first == by_id.begin()->first + by_id.size() - 1);
    std::uint32_t far = 0;
    for (auto it = std::next(by_id.begin()); it != by_id.end(); ++it) {
        const pmtiles::TileAddress& before = std::prev(it)->second;
        const auto apart = [](std::uint32_t a, std::uint32_t b) { return a > b ? a - b : b - a; };
        far += apart(before.column, it->second.column) + apart(before.row, it->second.row) != 1;
    }
    CHECK(far == 0);
}
