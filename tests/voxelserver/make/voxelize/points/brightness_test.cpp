// Intensities of flight lines on one scale.
#include "voxelserver/make/voxelize/points/brightness.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/catch.hpp"

using namespace terravox;
using namespace terravox::voxelize;

namespace {

/// Ground 600 x 300 m: asphalt in the south, meadow in the north, both as bright everywhere. Lines
/// overlap by 100 m.
std::vector<GroundEcho> echoes(const std::vector<double>& gains, unsigned seed = 3) {
    std::mt19937 random(seed);
    const auto unit = [&] { return static_cast<double>(random() % 100'000) / 100'000; };
    std::vector<GroundEcho> out;
    const double width = 600.0 / static_cast<double>(gains.size());
    for (std::size_t line = 0; line < gains.size(); ++line)
        for (int i = 0; i < 3000; ++i) {
            const double x = width * static_cast<double>(line) - 50 + unit() * (width + 100);
            const double z = unit() * 300;
            const double light = (z > 200 ? 6000 : 20'000) * (0.9 + 0.2 * unit());
            out.push_back({x, z, static_cast<std::uint16_t>(light * gains[line]),
                           static_cast<std::uint16_t>(line + 1)});
        }
    return out;
}

}  // namespace

TEST_CASE("a gain of each flight line does not change its brightness",
          "[voxelserver][voxelize][brightness]") {
    const auto gains = GENERATE(std::vector<double>{1, 1, 1}, std::vector<double>{1, 0.5, 1.7},
                                std::vector<double>{2.5, 0.3, 0.9, 1.4});
    const BrightnessScale scale = scale_from(echoes(gains), 1);
    REQUIRE(scale.lines().size() == gains.size());
    for (std::size_t line = 0; line < gains.size(); ++line) {
        const auto number = static_cast<std::uint16_t>(line + 1);
        const auto bright = [&](double light) {
            return scale.brightness(static_cast<std::uint16_t>(light * gains[line]), number);
        };
        INFO("line " << number << ", gain " << gains[line]);
        CHECK(std::abs(bright(20'000) - 94) <= 4);
        CHECK(std::abs(bright(6000) - 28) <= 2);
    }
}

TEST_CASE("the order of echoes does not matter", "[voxelserver][voxelize][brightness]") {
    auto list = echoes({1, 0.6, 1.3});
    const auto reference = scale_from(list, 1).lines();
    std::shuffle(list.begin(), list.end(), std::mt19937(11));
    CHECK(scale_from(list, 1).lines() == reference);
}

TEST_CASE("little, even or strange intensities say nothing",
          "[voxelserver][voxelize][brightness]") {
    auto list = echoes({1, 1});
    SECTION("few echoes") {
        list.resize(63);
        CHECK_FALSE(scale_from(list, 1).is_known());
    }
    SECTION("all alike") {
        for (GroundEcho& e : list)
            e.intensity = 1000;
        CHECK_FALSE(scale_from(list, 1).is_known());
    }
    SECTION("a line for every echo") {
        for (std::size_t i = 0; i < list.size(); ++i)
            list[i].line = static_cast<std::uint16_t>(i);
        CHECK_FALSE(scale_from(list, 1).is_known());
    }
    SECTION("none") {
        CHECK_FALSE(scale_from({}, 1).is_known());
    }
    const BrightnessScale scale = scale_from(echoes({1, 1}), 1);
    CHECK(scale.brightness(0, 1) == BrightnessScale::kUnknown);
    CHECK(scale.brightness(5000, 77) == BrightnessScale::kUnknown);
    CHECK(scale.brightness(65535, 1) == 255);
    CHECK(scale.brightness(1, 1) == 1);
}

TEST_CASE("a line apart from the others has a scale of its own",
          "[voxelserver][voxelize][brightness]") {
    auto list = echoes({1, 1});
    const auto apart = echoes({0.25}, 5);
    for (GroundEcho e : apart) {
        e.x += 5000;
        e.line = 9;
        list.push_back(e);
    }
    const BrightnessScale scale = scale_from(list, 1);
    CHECK(std::abs(scale.brightness(5000, 9) - scale.brightness(20'000, 1)) <= 3);
}

TEST_CASE("files take the echoes of their neighbours into account, and of no file far away",
          "[voxelserver][voxelize][brightness]") {
    const std::vector<grid::ColumnRect> bounds{
        {0, 0, 600, 300}, {600, 0, 1200, 300}, {9000, 0, 9600, 300}};
    CHECK(files_sharing_scale(0, bounds, 1) == std::vector<std::size_t>{0, 1});
    CHECK(files_sharing_scale(1, bounds, 1) == std::vector<std::size_t>{0, 1});
    CHECK(files_sharing_scale(2, bounds, 1) == std::vector<std::size_t>{2});
}
