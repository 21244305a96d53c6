#include "raytracer/tiles/tile_plan.hpp"

#include <algorithm>
#include <random>
#include <set>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/scene_words_text.hpp"

using namespace terravox;
using terravox::test::contains;

namespace {

constexpr core::TileOrder kOrders[] = {core::TileOrder::kSpiral, core::TileOrder::kVertical,
                                       core::TileOrder::kVerticalSplit, core::TileOrder::kHilbert,
                                       core::TileOrder::kRows};

}  // namespace

TEST_CASE("all passes together trace every pixel exactly once", "[raytracer][tiles]") {
    struct Case {
        const char* name;
        int width;
        int height;
        int tile;
        int coarse;
    };
    const auto c = GENERATE(values<Case>({
        {"one pixel", 1, 1, 64, 8},
        {"one pixel in one pass", 1, 1, 1, 1},
        {"a tiny picture", 7, 5, 64, 8},
        {"tiles of one pixel", 7, 5, 1, 4},
        {"HD", 1280, 720, 64, 8},
        {"not a multiple of the tile", 131, 67, 16, 8},
        {"tile not a multiple of the step", 131, 67, 10, 16},
        {"tile smaller than the step", 131, 67, 3, 64},
        {"tile larger than the picture", 50, 40, 1000, 2},
        {"one column", 1, 300, 16, 8},
        {"one row", 300, 1, 16, 8},
        {"odd tile, odd size", 99, 101, 7, 32},
    }));
    const core::TileOrder order = GENERATE(from_range(std::begin(kOrders), std::end(kOrders)));
    DYNAMIC_SECTION(c.name << ", " << order) {
        std::vector<int> traced(static_cast<std::size_t>(c.width * c.height));
        const auto passes = tiles::plan_tiles(c.width, c.height, c.coarse, c.tile, order);
        int outside = 0;
        for (std::size_t pass = 0; pass < passes.size(); ++pass)
            for (const tiles::RenderTile& tile : passes[pass]) {
                CHECK(tile.pass == pass);
                tile.each_pixel([&](int x, int y) {
                    if (x < tile.x0 || y < tile.y0 || x >= tile.x1 || y >= tile.y1 ||
                        x >= c.width || y >= c.height)
                        ++outside;
                    else
                        ++traced[static_cast<std::size_t>(y * c.width + x)];
                });
            }
        CHECK(outside == 0);
        CHECK(std::all_of(traced.begin(), traced.end(), [](int n) { return n == 1; }));
        CHECK(passes.back().front().step == 1);
        CHECK((1 << (passes.size() - 1)) == c.coarse);
    }
}

TEST_CASE("every order of tiles is a permutation of the same tiles, numbered in that order",
          "[raytracer][tiles]") {
    using Corner = std::pair<int, int>;
    std::set<Corner> corners[std::size(kOrders)];
    for (std::size_t i = 0; i < std::size(kOrders); ++i) {
        const auto tiles = tiles::plan_tiles(333, 200, 1, 32, kOrders[i]).front();
        for (std::size_t k = 0; k < tiles.size(); ++k) {
            CHECK(tiles[k].index == k);
            CHECK(corners[i].insert({tiles[k].x0, tiles[k].y0}).second);
        }
        CHECK(corners[i].size() == 11 * 7);
        CHECK(corners[i] == corners[0]);
    }
}

TEST_CASE("pictures, tiles and passes of any size trace every pixel exactly once",
          "[raytracer][tiles]") {
    std::mt19937 random(2016);
    const auto up_to = [&](int most) {
        return 1 + static_cast<int>(random() % static_cast<unsigned>(most));
    };
    for (int run = 0; run < 300; ++run) {
        const int width = up_to(150);
        const int height = up_to(150);
        const int tile = up_to(run % 2 == 0 ? 12 : 200);
        const int coarse = 1 << random() % 7;
        const core::TileOrder order = kOrders[random() % std::size(kOrders)];
        INFO(width << "x" << height << ", tile " << tile << ", first step " << coarse << ", "
                   << order);
        std::vector<int> traced(static_cast<std::size_t>(width * height));
        for (const auto& tiles : tiles::plan_tiles(width, height, coarse, tile, order))
            for (const tiles::RenderTile& t : tiles)
                t.each_pixel(
                    [&](int x, int y) { ++traced.at(static_cast<std::size_t>(y * width + x)); });
        CHECK(std::all_of(traced.begin(), traced.end(), [](int n) { return n == 1; }));
    }
}

TEST_CASE(
    "more tiles than memory is meant for are refused, and the largest picture in tiles of 64 is "
    "not",
    "[raytracer][tiles]") {
    CHECK(tiles::plan_tiles(65'536, 65'536, 1, 64, core::TileOrder::kHilbert).front().size() ==
          1 << 20);
    CHECK_THROWS_AS(tiles::plan_tiles(65'536, 65'536, 1, 1, core::TileOrder::kRows),
                    util::UsageError);
    CHECK_THROWS_WITH(tiles::plan_tiles(65'536, 65'536, 1, 63, core::TileOrder::kRows),
                      contains("65536x65536") && contains("quality.tile larger"));
}

TEST_CASE("the spiral starts in the middle and moves outwards", "[raytracer][tiles]") {
    const auto tiles = tiles::plan_tiles(7 * 32, 5 * 32, 1, 32, core::TileOrder::kSpiral).front();
    CHECK(tiles.front().x0 == 3 * 32);
    CHECK(tiles.front().y0 == 2 * 32);
    double ring = 0;
    for (const tiles::RenderTile& t : tiles) {
        const double here = std::max(std::abs(t.x0 / 32 - 3), std::abs(t.y0 / 32 - 2));
        CHECK(here >= ring);
        ring = here;
    }
}

TEST_CASE("a first step that is no power of two is refused", "[raytracer][tiles]") {
    for (const int bad : {0, -1, -8, 3, 6, 7, 12, 63}) {
        INFO(bad);
        CHECK_THROWS_AS(tiles::plan_tiles(64, 64, bad, 16, core::TileOrder::kRows),
                        util::UsageError);
        CHECK_THROWS_WITH(tiles::plan_tiles(64, 64, bad, 16, core::TileOrder::kRows),
                          contains("quality.coarse_step = " + std::to_string(bad)) &&
                              contains("allowed: 1, 2, 4"));
    }
}
