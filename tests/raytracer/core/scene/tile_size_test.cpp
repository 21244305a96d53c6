#include "raytracer/core/scene/scene.hpp"

#include <cmath>
#include <random>

#include "tests/catch.hpp"

using namespace terravox;

TEST_CASE("the size of a tile is pixels or a share of the picture's width", "[raytracer][scene]") {
    struct Case {
        const char* text;
        int width_px;
        int px;
    };
    const auto c = GENERATE(values<Case>({
        {"64", 1280, 64},
        {"1", 1, 1},
        {"4096", 10, 4096},
        {"5%", 1280, 64},
        {"100%", 1280, 1280},
        {"0.1%", 1280, 1},
        {"0.1%", 10, 1},
        {"50%", 3, 2},
        {"33.3%", 100, 33},
        {"1e1%", 200, 20},
        {"100%", 65536, 4096},
    }));
    DYNAMIC_SECTION(c.text << " of " << c.width_px) {
        const auto size = scene::TileSize::parse(c.text);
        REQUIRE(size);
        CHECK(size->in_picture(c.width_px) == c.px);
    }
}

TEST_CASE("what is no size of a tile is none", "[raytracer][scene]") {
    const std::string text =
        GENERATE("", "%", "0", "-1", "4097", "64px", " 64", "64 ", "6.4", "0%", "0.09%", "100.1%",
                 "-5%", "nan%", "inf%", "1e999%", "5%%", "5 %", "0x10", "99999999999999");
    INFO("'" << text << "'");
    CHECK_FALSE(scene::TileSize::parse(text));
}
