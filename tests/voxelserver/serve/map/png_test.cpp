#include "voxelserver/serve/map/pixels.hpp"

#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/serve/map/png_pixels.hpp"

using namespace terravox;

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
