#include "raytracer/tiles/tile_order.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
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
    DYNAMIC_SECTION(core::word_of(c.order) << ", " << c.columns << " x " << c.rows) {
        CHECK((tiles::order_cells(c.columns, c.rows, c.order) == c.cells));
    }
}

TEST_CASE("neighbours on the Hilbert curve touch", "[raytracer][tiles]") {
    for (int edge = 1; edge <= 256; edge *= 2) {
        INFO("edge " << edge);
        const auto cells = tiles::order_cells(edge, edge, core::TileOrder::kHilbert);
        CHECK((cells.front() == tiles::TileCell{0, 0}));
        CHECK((cells.back() == tiles::TileCell{edge - 1, 0}));
        int apart = 0;
        for (std::size_t i = 1; i < cells.size(); ++i)
            if (std::abs(cells[i].column - cells[i - 1].column) +
                    std::abs(cells[i].row - cells[i - 1].row) !=
                1)
                ++apart;
        CHECK(apart == 0);
    }
}

TEST_CASE("on other grids the Hilbert curve leaves out what lies outside", "[raytracer][tiles]") {
    std::mt19937 random(7);
    for (int run = 0; run < 60; ++run) {
        const int columns = 1 + static_cast<int>(random() % 64);
        const int rows = 1 + static_cast<int>(random() % 64);
        INFO(columns << " x " << rows);
        int edge = 1;
        while (edge < std::max(columns, rows))
            edge *= 2;
        std::vector<tiles::TileCell> inside;
        for (const tiles::TileCell& c : tiles::order_cells(edge, edge, core::TileOrder::kHilbert))
            if (c.column < columns && c.row < rows)
                inside.push_back(c);
        CHECK((tiles::order_cells(columns, rows, core::TileOrder::kHilbert) == inside));
    }
}

TEST_CASE("the spiral's rings grow from the middle, each clockwise", "[raytracer][tiles]") {
    std::mt19937 random(11);
    for (int run = 0; run < 100; ++run) {
        const int columns = 1 + static_cast<int>(random() % 40);
        const int rows = 1 + static_cast<int>(random() % 40);
        INFO(columns << " x " << rows);
        int ring = 0;
        int turns_back = 0;
        double angle = -10;
        for (const tiles::TileCell& c :
             tiles::order_cells(columns, rows, core::TileOrder::kSpiral)) {
            const int x = 2 * c.column - (columns - 1);
            const int y = 2 * c.row - (rows - 1);
            const int here = std::max(std::abs(x), std::abs(y));
            REQUIRE(here >= ring);
            // From the upper left corner on: there the angle is 0, and it grows clockwise.
            const double turned =
                std::fmod(std::atan2(y, x) + 2.75 * 3.14159265358979 + 1e-9, 2 * 3.14159265358979);
            if (here == ring && turned < angle)
                ++turns_back;
            ring = here;
            angle = turned;
        }
        CHECK(turns_back == 0);
    }
}

TEST_CASE("in split columns the halves take turns, and no column begins before the last one ends",
          "[raytracer][tiles]") {
    for (const int rows : {1, 2, 3, 8, 13}) {
        INFO(rows << " rows");
        const auto cells = tiles::order_cells(4, rows, core::TileOrder::kVerticalSplit);
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const int n = static_cast<int>(i) % rows;
            CHECK(cells[i].column == static_cast<int>(i) / rows);
            CHECK((cells[i].row >= (rows + 1) / 2) == (n % 2 == 1));
        }
    }
}

TEST_CASE("long grids are ordered without going through the square around them",
          "[raytracer][tiles]") {
    for (const auto& [order, word] : core::kTileOrders) {
        INFO(word);
        CHECK(tiles::order_cells(1 << 20, 1, order).size() == 1 << 20);
        CHECK((tiles::order_cells(1, 1 << 20, order).back().column == 0));
    }
}
