#include "raytracer/analyse/raster/relief.hpp"

#include <cmath>

#include "tests/catch.hpp"

namespace {

using namespace terravox;
using analyse::CellPatch;

template <class Height>
CellPatch make_patch(int width, int height, const Height& height_at) {
    CellPatch out{width, height, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            out.values.push_back(static_cast<float>(height_at(x, y)));
    return out;
}

}  // namespace

TEST_CASE("slope and aspect of planes are exact", "[raytracer][analyse]") {
    struct Plane {
        const char* name;
        double east;
        double north;
        double slope;
        double aspect;
    };
    const Plane planes[] = {
        {"falls to the west", 1, 0, 45, 270},
        {"falls to the east", -1, 0, 45, 90},
        {"falls to the south", 0, 1, 45, 180},
        {"falls to the north", 0, -1, 45, 0},
        {"falls to the south-east", -0.25, 0.25, std::atan(std::sqrt(0.125)) * 180 / M_PI, 135},
    };
    for (const Plane& p : planes) {
        INFO(p.name);
        const double edge_m = 2;
        // Rows run to the south.
        const CellPatch patch = make_patch(
            9, 9, [&](int x, int y) { return 300 + edge_m * (p.east * x - p.north * y); });
        for (const int x : {0, 4, 8}) {
            const auto gradient = analyse::gradient_at(patch, x, 4, 2, edge_m);
            REQUIRE(gradient);
            CHECK(std::abs(analyse::slope_deg(*gradient) - p.slope) < 1e-4);
            const auto aspect = analyse::aspect_deg(*gradient);
            REQUIRE(aspect);
            CHECK(std::abs(*aspect - p.aspect) < 1e-4);
        }
    }
}

TEST_CASE("level ground has no aspect, and light at its altitude", "[raytracer][analyse]") {
    const CellPatch patch = make_patch(5, 5, [](int, int) { return 7; });
    const auto gradient = analyse::gradient_at(patch, 2, 2, 1, 1);
    REQUIRE(gradient);
    CHECK(analyse::slope_deg(*gradient) == 0);
    CHECK_FALSE(analyse::aspect_deg(*gradient));
    CHECK(analyse::hillshade(*gradient, 315, 90) == 255);
    CHECK(analyse::hillshade(*gradient, 315, 30) == 128);
    CHECK(analyse::hillshade({0, 10}, 0, 20) == 1);
    CHECK(analyse::hillshade({0, 1}, 180, 45) == 255);
}

TEST_CASE("covered ground is interpolated from around, within reach, and below the surface",
          "[raytracer][analyse]") {
    const auto slope = [](int x, int) { return 10 + x; };
    CellPatch ground = make_patch(21, 21, slope);
    CellPatch surface = make_patch(21, 21, slope);
    for (int y = 6; y < 15; ++y)
        for (int x = 6; x < 15; ++x) {
            ground.values[ground.index(x, y)] = core::kNoData;
            surface.values[surface.index(x, y)] = 50;
        }
    surface.values[surface.index(7, 7)] = 11;               // a cellar's roof
    surface.values[surface.index(14, 14)] = core::kNoData;  // nothing is there
    CellPatch filled = ground;
    CellPatch source;
    analyse::fill_ground(filled, surface, 20, source);
    CHECK(std::abs(filled.at(10, 10) - 20) < 0.01F);
    CHECK(std::abs(filled.at(8, 10) - 18) < 1);
    CHECK(filled.at(7, 7) == 11);
    CHECK(filled.at(14, 14) == core::kNoData);
    CHECK(filled.at(3, 3) == 13);
    CHECK(source.at(10, 10) == analyse::kInterpolatedGround);
    CHECK(source.at(3, 3) == analyse::kMeasuredGround);
    CHECK(source.at(14, 14) == core::kNoData);
    filled = ground;
    analyse::fill_ground(filled, surface, 4, source);
    CHECK(filled.at(10, 10) == core::kNoData);
    CHECK(filled.at(9, 10) != core::kNoData);
    filled = ground;
    analyse::fill_ground(filled, surface, 0, source);
    CHECK(filled.values == ground.values);
}
