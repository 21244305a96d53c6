#include "raytracer/farm/checkpoint/checkpoint.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;

TEST_CASE("every tile belongs to one part, and parts have as many tiles",
          "[raytracer][checkpoint][part]") {
    struct Case {
        std::uint32_t columns, rows, parts;
    };
    const auto c = GENERATE(values<Case>({{1, 1, 1},
                                          {20, 12, 1},
                                          {20, 12, 2},
                                          {20, 12, 3},
                                          {21, 13, 4},
                                          {16, 16, 16},
                                          {30, 17, 7},
                                          {64, 36, 10},
                                          {100, 100, 64},
                                          {3, 2, 10},
                                          {128, 72, 100}}));
    CAPTURE(c.columns, c.rows, c.parts);
    std::vector<int> tiles(c.parts);
    for (std::uint32_t y = 0; y < c.rows; ++y)
        for (std::uint32_t x = 0; x < c.columns; ++x) {
            int owners = 0;
            for (std::uint32_t i = 1; i <= c.parts; ++i)
                if (farm::Part{i, c.parts}.has(x, y)) {
                    ++owners;
                    ++tiles[i - 1];
                }
            REQUIRE(owners == 1);
        }
    const auto [least, most] = std::minmax_element(tiles.begin(), tiles.end());
    CHECK(*most - *least <= std::max(2, static_cast<int>(c.columns * c.rows / c.parts / 20)));
}

TEST_CASE("a part is written I/N", "[raytracer][checkpoint][part]") {
    CHECK(farm::Part::parse("2/5") == farm::Part{2, 5});
    CHECK(farm::Part::parse("1/1") == farm::Part{1, 1});
    CHECK(farm::Part::parse("65536/65536") == farm::Part{65'536, 65'536});
    for (const char* wrong : {"", "1", "/", "1/", "/2", "0/2", "3/2", "1/0", "-1/2", "1/2 ", " 1/2",
                              "1/2/3", "a/b", "1.5/2", "1/65537", "99999999999/99999999999"}) {
        INFO(wrong);
        CHECK_FALSE(farm::Part::parse(wrong));
    }
}
