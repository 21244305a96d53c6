#include "voxelserver/serve/map/pixels.hpp"

#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/serve/map/png_pixels.hpp"

using namespace terravox;
using map::ColumnTop;
using voxel::Material;

namespace {

std::uint32_t measure_shade(const std::array<std::int32_t, 9>& heights) {
    std::array<ColumnTop, 9> tops;
    map::TopWindow window{};
    for (std::size_t i = 0; i < 9; ++i) {
        tops[i] = {heights[i], {}, Material::kGround};
        window[i] = &tops[i];
    }
    return map::hill_shade(window);
}

}  // namespace

TEST_CASE("slopes towards the north-west are bright, those away from it dark", "[map][shade]") {
    struct Case {
        const char* name;
        std::array<std::int32_t, 9> heights;
        int sign;
    };
    const auto c = GENERATE(values<Case>({
        {"level", {5, 5, 5, 5, 5, 5, 5, 5, 5}, 0},
        {"rises to the east: faces west", {0, 1, 2, 0, 1, 2, 0, 1, 2}, 1},
        {"rises to the west", {2, 1, 0, 2, 1, 0, 2, 1, 0}, -1},
        {"rises to the south: faces north", {0, 0, 0, 1, 1, 1, 2, 2, 2}, 1},
        {"rises to the north", {2, 2, 2, 1, 1, 1, 0, 0, 0}, -1},
        {"rises to the south-east", {0, 1, 2, 1, 2, 3, 2, 3, 4}, 1},
        {"rises to the north-west", {4, 3, 2, 3, 2, 1, 2, 1, 0}, -1},
        {"a wall", {0, 0, 0, 0, 0, 0, -90, -90, -90}, -1},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto shade = static_cast<int>(measure_shade(c.heights));
        const int flat = map::kFlatShade;
        CHECK((shade > flat) - (shade < flat) == c.sign);
    }
}

TEST_CASE("shade stays within its range for any heights", "[map][shade]") {
    std::mt19937_64 random(3);
    for (int i = 0; i < 20000; ++i) {
        std::array<std::int32_t, 9> heights;
        for (auto& h : heights)
            h = i % 2 == 0 ? static_cast<std::int32_t>(random())
                           : static_cast<std::int32_t>(random() % 7);
        const std::uint32_t shade = measure_shade(heights);
        INFO("round " << i);
        REQUIRE(shade >= map::kFlatShade * 6 / 10);
        REQUIRE(shade <= map::kFlatShade * 5 / 4);
    }
    CHECK(measure_shade({INT32_MIN, INT32_MIN, INT32_MIN, INT32_MAX, INT32_MAX, INT32_MAX,
                         INT32_MIN, 0, INT32_MAX}) > 0);
}

TEST_CASE(
    "water is not shaded, nothing is transparent, and nothing next to a column is level with it",
    "[map][shade]") {
    std::array<ColumnTop, 9> tops;
    map::TopWindow window{};
    for (std::size_t i = 0; i < 9; ++i) {
        tops[i] = {static_cast<std::int32_t>(i % 3), {90, 120, 60}, Material::kGrass};
        window[i] = &tops[i];
    }
    const map::Rgba8 lit = map::shaded_pixel(window);
    CHECK(lit.r > 90);
    CHECK(lit.a == 255);
    for (std::size_t i = 0; i < 9; ++i)
        if (i != 4)
            tops[i].material = Material::kAir;
    CHECK(map::shaded_pixel(window) == map::Rgba8{90, 120, 60, 255});
    for (auto& top : tops)
        top.material = Material::kWater;
    CHECK(map::shaded_pixel(window) == map::Rgba8{90, 120, 60, 255});
    tops[4].material = Material::kAir;
    CHECK(map::shaded_pixel(window) == map::Rgba8{});
}

TEST_CASE("a PNG holds the pixels that were given, also noise, and no time", "[map][png]") {
    std::mt19937_64 random(1);
    struct Case {
        int width;
        int height;
    };
    for (const auto [width, height] : {Case{1, 1}, Case{256, 256}, Case{3, 700}}) {
        std::vector<map::Rgba8> pixels(static_cast<std::size_t>(width * height));
        for (auto& p : pixels) {
            const auto byte = [&] { return static_cast<std::uint8_t>(random()); };
            p = {byte(), byte(), byte(), byte()};
        }
        const std::string bytes = map::to_png(pixels, width, height);
        const auto back = test::read_png(bytes);
        CHECK(back.width == width);
        CHECK(back.height == height);
        CHECK(back.pixels == pixels);
        CHECK(bytes == map::to_png(pixels, width, height));
        CHECK(bytes.find("tIME") == std::string::npos);
    }
}

TEST_CASE("sizes that do not fit are refused", "[map][png]") {
    const std::vector<map::Rgba8> pixels(12);
    CHECK_THROWS_WITH(map::to_png(pixels, 4, 4), test::contains("48 samples were given, not 64"));
    CHECK_THROWS_AS(map::to_png(pixels, 0, 0), util::Error);
    CHECK_THROWS_AS(map::to_png(pixels, -3, -4), util::Error);
    CHECK_THROWS_AS(map::to_png(pixels, 1 << 30, 4), util::Error);
}
