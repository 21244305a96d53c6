#include "voxelserver/data/sunlight/sun.hpp"

#include <array>
#include <cmath>

#include "tests/catch.hpp"
#include "tests/voxelserver/data/sunlight/made_town.hpp"

using namespace terravox::sunlight;
using namespace terravox::sunlight::test;

namespace {

double turn_between(double a, double b) {
    const double turn = std::abs(a - b);
    return std::min(turn, 360 - turn);
}

}  // namespace

TEST_CASE("the sun is found from the shadows of houses, in haze and under clouds, too",
          "[sunlight][finder]") {
    struct Case {
        std::uint32_t seed;
        Sun sun;
        Weather weather;
    };
    const auto c = GENERATE(values<Case>({
        {1, {150, 40}, {0.2F, 0, 0}},
        {2, {203, 33}, {0.15F, 0, 0}},
        {3, {95, 25}, {0.25F, 0, 0}},
        {4, {268, 52}, {0.2F, 0, 0}},
        {7, {162, 49}, {0.45F, 0.1F, 0}},
        {9, {140, 36}, {0.4F, 0.05F, 0.5F}},
    }));
    DYNAMIC_SECTION("town " << c.seed << ", sun " << c.sun.azimuth_deg << ", "
                            << c.sun.altitude_deg) {
        const std::array scenes{MadeTown(c.seed).photographed(c.sun, c.weather)};
        const auto found = find_sun(scenes);
        REQUIRE(found);
        CAPTURE(found->sun.azimuth_deg, found->sun.altitude_deg, found->correlation, found->margin);
        CHECK(turn_between(found->sun.azimuth_deg, c.sun.azimuth_deg) <= 3);
        CHECK(std::abs(found->sun.altitude_deg - c.sun.altitude_deg) <= 3);
        CHECK(is_certain(*found));
    }
}

TEST_CASE("no sun is certain where nothing casts a shadow, or a photograph shows another place",
          "[sunlight][finder]") {
    const MadeTown here(1);
    const MadeTown elsewhere(2);
    SECTION("no shadow") {
        const std::array scenes{here.photographed({150, 40}, {1, 0, 0})};
        CHECK_FALSE(is_certain(find_sun(scenes).value()));
    }
    SECTION("another place") {
        Scene scene = here.photographed({150, 40}, {});
        scene.photo = elsewhere.photographed({150, 40}, {}).photo;
        const std::array scenes{scene};
        const SunEstimate found = find_sun(scenes).value();
        CAPTURE(found.correlation, found.margin);
        CHECK_FALSE(is_certain(found));
    }
}

TEST_CASE("nothing is estimated from a few cells", "[sunlight][finder]") {
    Scene scene(80, 80, 30, 1);
    fill_gaps(scene);
    CHECK_FALSE(find_sun(std::array{scene}));
    CHECK_FALSE(find_sun({}));
}
