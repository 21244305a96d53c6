#include "voxelserver/tools/survey/orthophoto.hpp"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/voxelserver/tools/survey/survey_fixture.hpp"

using namespace terravox::survey;
using namespace terravox::survey::test;

namespace {

const auto kSilently = [](const SquareReport&, std::size_t) {};

SurveyOptions lit_survey(const std::filesystem::path& folder) {
    auto options = small_survey(folder);
    options.square_m = 128;
    options.density = 0.5;
    options.photo_light = PhotoLight{150, 35, 0.2, 0.3};
    return options;
}

double measure_mean(const std::vector<std::uint8_t>& values) {
    double sum = 0;
    for (const std::uint8_t v : values)
        sum += v;
    return sum / static_cast<double>(values.size());
}

}  // namespace

TEST_CASE("a photograph in the sun comes with its albedo and says its light",
          "[survey][photo-light]") {
    const TemporaryFolder folder;
    const auto report = run_survey(lit_survey(folder.path()), kSilently).front();
    CHECK(std::filesystem::exists(folder.path() / "truth" / ("albedo_" + report.name + ".tif")));
    std::ifstream in(folder.path() / "truth/place.json");
    const auto place = nlohmann::json::parse(in);
    CHECK(place.at("photo_light").at("azimuth_deg") == 150);
    CHECK(place.at("photo_light").at("altitude_deg") == 35);
    CHECK(place.at("photo_light").at("haze") == 0.2);
    CHECK(place.at("photo_light").at("clouds") == 0.3);

    const TemporaryFolder plain;
    auto options = lit_survey(plain.path());
    options.photo_light.reset();
    run_survey(options, kSilently);
    CHECK_FALSE(
        std::filesystem::exists(plain.path() / "truth" / ("albedo_" + report.name + ".tif")));
}

TEST_CASE("what lies in the sun has its own colour, what lies in the shadow is darker",
          "[survey][photo-light]") {
    // The village, where houses cast shadows.
    const SquareModel model(7, {462592, 101360, 128}, 2);
    const LitPhoto lit = take_photo(model, {150, 30, 0, 0});
    REQUIRE(lit.photo.pixels.size() == lit.albedo.pixels.size());
    std::size_t same = 0;
    std::size_t dark = 0;
    for (std::size_t i = 1; i < lit.photo.pixels.size(); i += 3) {
        const int difference = lit.photo.pixels[i] - lit.albedo.pixels[i];
        same += std::abs(difference) <= 8 ? 1 : 0;
        dark += 2 * lit.photo.pixels[i] < lit.albedo.pixels[i] + 10 ? 1 : 0;
    }
    const auto pixels = static_cast<double>(lit.photo.pixels.size()) / 3;
    CHECK(static_cast<double>(same) > 0.3 * pixels);
    CHECK(static_cast<double>(dark) > 0.05 * pixels);

    SECTION("a lower sun casts longer shadows") {
        const LitPhoto low = take_photo(model, {150, 15, 0, 0});
        CHECK(measure_mean(low.photo.pixels) < measure_mean(lit.photo.pixels) - 5);
    }
    SECTION("haze makes the darkest brighter") {
        const LitPhoto haze = take_photo(model, {150, 30, 1, 0});
        CHECK(*std::min_element(haze.photo.pixels.begin(), haze.photo.pixels.end()) >
              *std::min_element(lit.photo.pixels.begin(), lit.photo.pixels.end()) + 20);
    }
}

TEST_CASE("without light the colours of a painting are its albedo", "[survey][photo-light]") {
    const SquareModel model(7, {462592, 101360, 64}, 1);
    const Painting flat = paint(model, Shading::kNone, 0);
    const Painting soft = paint(model, Shading::kSoft, 0);
    CHECK(flat.rgb.size() == soft.rgb.size());
    CHECK(flat.top_m == soft.top_m);
    CHECK(flat.slope.size() == flat.top_m.size());
    CHECK(soft.slope.empty());
    CHECK(paint_orthophoto(model).pixels == soft.rgb);
}
