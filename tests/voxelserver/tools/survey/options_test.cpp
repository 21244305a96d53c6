#include "common/util/error.hpp"
#include "survey_fixture.hpp"
#include "voxelserver/tools/survey/survey_options.hpp"

using namespace terravox;
using namespace terravox::survey;

namespace {

std::optional<SurveyOptions> parsed(std::vector<const char*> arguments) {
    arguments.insert(arguments.begin(), "terravox-survey");
    std::optional<int> exit_code;
    return parse_options(static_cast<int>(arguments.size()), arguments.data(), exit_code);
}

}  // namespace

TEST_CASE("values out of range are usage errors that name option, value and range",
          "[survey][options]") {
    struct Case {
        const char* option;
        const char* value;
    };
    const auto c = GENERATE(values<Case>({
        {"--density", "0.05"},     {"--density", "201"},
        {"--density", "nan"},      {"--density", "8x"},
        {"--squares", "0x1"},      {"--squares", "1x101"},
        {"--squares", "3"},        {"--squares", "2x2x2"},
        {"--seed", "-1"},          {"--seed", "18446744073709551616"},
        {"--seed", "seven"},       {"--square-m", "100"},
        {"--square-m", "48"},      {"--square-m", "1008"},
        {"--origin", "462"},       {"--origin", "462.0005,101"},
        {"--origin", "-1,101"},    {"--threads", "-1"},
        {"--photo-sun", "150"},    {"--photo-sun", "150,5"},
        {"--photo-sun", "361,40"}, {"--photo-sun", "150,nan"},
        {"--photo-haze", "0.5"},   {"--photo-clouds", "0.5"},
    }));
    DYNAMIC_SECTION(c.option << " " << c.value) {
        const std::string joined = std::string(c.option) + "=" + c.value;
        try {
            parsed({joined.c_str(), "-o", "x"});
            FAIL("accepted");
        } catch (const util::UsageError& error) {
            CHECK(std::string(error.what()).find(c.option) != std::string::npos);
            CHECK(error.exit_code() == util::ExitCode::kUsage);
        }
    }
}

TEST_CASE("unknown flags and a missing folder are usage errors", "[survey][options]") {
    CHECK_THROWS_AS(parsed({"--colour", "-o", "x"}), util::UsageError);
    CHECK_THROWS_AS(parsed({"--seed", "3"}), util::UsageError);
}

TEST_CASE("the command line of the manual is understood", "[survey][options]") {
    const auto options =
        parsed({"--seed", "9", "--squares", "2x3", "--density", "0.5", "-o", "out"});
    REQUIRE(options);
    CHECK(options->seed == 9);
    CHECK(options->density == 0.5);
    const auto squares = list_squares(*options);
    REQUIRE(squares.size() == 6);
    CHECK(squares.front().name() == "TM_462_101");
    CHECK(squares.back().name() == "TM_463_103");
}

TEST_CASE("the light of the photograph is that of the options", "[survey][options]") {
    CHECK_FALSE(parsed({"-o", "out"})->photo_light);
    const auto options = parsed({"--photo-sun", "150,40.5", "--photo-haze", "0.25", "-o", "out"});
    REQUIRE(options);
    REQUIRE(options->photo_light);
    CHECK(options->photo_light->azimuth_deg == 150);
    CHECK(options->photo_light->altitude_deg == 40.5);
    CHECK(options->photo_light->haze == 0.25);
    CHECK(options->photo_light->clouds == 0);
    CHECK_THROWS_AS(parsed({"--photo-sun", "150,40", "--photo-haze", "2", "-o", "out"}),
                    util::UsageError);
}

TEST_CASE("a small square starts around the middle of the place, on a multiple of 16 m",
          "[survey][options]") {
    const auto options = parsed({"--square-m", "512", "-o", "out"});
    REQUIRE(options);
    CHECK(list_squares(*options).front().name() == "TM_462240_101232");
    const auto placed = parsed({"--square-m", "256", "--origin", "463.5,102.25", "-o", "out"});
    REQUIRE(placed);
    CHECK(list_squares(*placed).front().name() == "TM_463500_102250");
}
