#include "voxelserver/make/voxelize/steps/photo_light.hpp"

#include <limits>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;
using voxelize::PhotoLight;

namespace {

PhotoLight made_light() {
    PhotoLight out;
    out.light.sun = sunlight::Sun{150, 40};
    out.light.sky = {0.2F, 0.25F, 0.3F};
    out.light.veil = {0.01F, 0.02F, 0};
    out.light.gain = {1.25F, 1, 0.5F};
    out.light.typical = {0, 0.1F, 0.2F, 0.3F, 0.4F};
    out.estimate = {{151, 41}, -0.5, 0.25};
    return out;
}

}  // namespace

TEST_CASE("the light of a photograph is read as it was written",
          "[voxelserver][voxelize][photo-light]") {
    PhotoLight light = made_light();
    SECTION("with a sun") {}
    SECTION("without one") {
        light.light.sun.reset();
    }
    const auto read = voxelize::parse_photo_light(to_bytes(light));
    REQUIRE(read);
    REQUIRE(read->light.sun.has_value() == light.light.sun.has_value());
    CHECK(read->light.typical == light.light.typical);
    CHECK(read->estimate.sun.azimuth_deg == light.estimate.sun.azimuth_deg);
    CHECK(read->estimate.margin == light.estimate.margin);
    CHECK(to_bytes(*read) == to_bytes(light));
}

TEST_CASE("what is no light of a photograph is not taken for one",
          "[voxelserver][voxelize][photo-light]") {
    const std::string good = to_bytes(made_light());
    for (std::size_t length = 0; length < good.size(); ++length)
        CHECK_FALSE(voxelize::parse_photo_light(std::string_view(good).substr(0, length)));
    CHECK_FALSE(voxelize::parse_photo_light(good + "x"));
    std::string other_version = good;
    ++other_version[0];
    CHECK_FALSE(voxelize::parse_photo_light(other_version));

    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    std::vector<PhotoLight> wrong(11, made_light());
    wrong[0].light.sky[1] = 0;
    wrong[1].light.sky[1] = kNan;
    wrong[2].light.veil[2] = -0.1F;
    wrong[3].light.gain[0] = 0;
    wrong[4].light.gain[0] = std::numeric_limits<float>::infinity();
    wrong[5].light.typical[3] = kNan;
    wrong[6].light.sun->altitude_deg = 0;
    wrong[7].light.sun->azimuth_deg = kNan;
    wrong[8].estimate.correlation = 2;
    wrong[9].estimate.correlation = static_cast<double>(kNan);
    wrong[10].estimate.margin = -1;
    for (std::size_t i = 0; i < wrong.size(); ++i) {
        INFO("case " << i);
        CHECK_FALSE(voxelize::parse_photo_light(to_bytes(wrong[i])));
    }
}
