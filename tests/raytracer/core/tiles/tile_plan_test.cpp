#include "raytracer/core/tiles/tile_plan.hpp"

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
        const auto passes = tiles::plan_tiles(width, height, coarse, tile, order);
        for (std::size_t pass = 0; pass < passes.size(); ++pass)
            for (std::size_t i = 0; i < passes[pass].size(); ++i) {
                const tiles::RenderTile& t = passes[pass][i];
                CHECK((t.pass == pass && t.index == i));
                t.each_pixel([&](int x, int y) {
                    REQUIRE((x >= t.x0 && y >= t.y0 && x < t.x1 && y < t.y1 && x < width));
                    ++traced.at(static_cast<std::size_t>(y * width + x));
                });
            }
        CHECK(std::all_of(traced.begin(), traced.end(), [](int n) { return n == 1; }));
        CHECK(passes.back().front().step == 1);
        CHECK((1 << (passes.size() - 1)) == coarse);
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
