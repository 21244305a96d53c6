#include "raytracer/core/tiles/tile_plan.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/catch.hpp"

using namespace terravox;

TEST_CASE("every order that a scene takes is a permutation of all tiles", "[raytracer][tiles]") {
    std::mt19937 random(462'101);
    for (int run = 0; run < 150; ++run) {
        // Squares, stripes and all between.
        const int columns = 1 + static_cast<int>(random() % (run % 3 == 0 ? 3 : 60));
        const int rows = 1 + static_cast<int>(random() % (run % 3 == 1 ? 3 : 60));
        for (const auto& [order, word] : core::kTileOrders) {
            INFO(word << ", " << columns << " x " << rows);
            const auto cells = tiles::order_cells(columns, rows, order);
            REQUIRE(cells.size() == static_cast<std::size_t>(columns * rows));
            std::vector<int> seen(cells.size());
            for (const tiles::TileCell& c : cells) {
                REQUIRE((c.column >= 0 && c.column < columns && c.row >= 0 && c.row < rows));
                ++seen[static_cast<std::size_t>(c.row * columns + c.column)];
            }
            CHECK(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
        }
    }
}

TEST_CASE("orders are what their names say", "[raytracer][tiles]") {
    struct Case {
        core::TileOrder order;
        int columns;
        int rows;
        std::vector<tiles::TileCell> cells;
    };
    const auto c = GENERATE(values<Case>({
        {core::TileOrder::kRows, 2, 3, {{0, 0}, {1, 0}, {0, 1}, {1, 1}, {0, 2}, {1, 2}}},
        {core::TileOrder::kVertical, 2, 3, {{0, 0}, {0, 1}, {0, 2}, {1, 0}, {1, 1}, {1, 2}}},
        {core::TileOrder::kVerticalSplit,
         2,
         4,
         {{0, 0}, {0, 2}, {0, 1}, {0, 3}, {1, 0}, {1, 2}, {1, 1}, {1, 3}}},
        {core::TileOrder::kVerticalSplit, 1, 5, {{0, 0}, {0, 3}, {0, 1}, {0, 4}, {0, 2}}},
        {core::TileOrder::kVerticalSplit, 2, 1, {{0, 0}, {1, 0}}},
        {core::TileOrder::kSpiral,
         3,
         3,
         {{1, 1}, {0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}},
        {core::TileOrder::kSpiral, 2, 2, {{0, 0}, {1, 0}, {1, 1}, {0, 1}}},
        {core::TileOrder::kSpiral, 4, 1, {{2, 0}, {1, 0}, {3, 0}, {0, 0}}},
        {core::TileOrder::kHilbert, 2, 2, {{0, 0}, {0, 1}, {1, 1}, {1, 0}}},
        {core::TileOrder::kHilbert, 4, 1, {{0, 0}, {1, 0}, {2, 0}, {3, 0}}},
        {core::TileOrder::kHilbert,
         4,
         4,
         {{0, 0},
          {1, 0},
          {1, 1},
          {0, 1},
          {0, 2},
          {0, 3},
          {1, 3},
          {1, 2},
          {2, 2},
          {2, 3},
          {3, 3},
          {3, 2},
          {3, 1},
          {2, 1},
          {2, 0},
          {3, 0}}},
    }));
    DYNAMIC_SECTION(core::to_word(c.order) << ", " << c.columns << " x " << c.rows) {
        CHECK((tiles::order_cells(c.columns, c.rows, c.order) == c.cells));
    }
}
