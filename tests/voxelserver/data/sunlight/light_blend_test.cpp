#include <algorithm>
#include <array>
#include <random>

#include "tests/catch.hpp"
#include "voxelserver/data/sunlight/flight_light.hpp"
#include "voxelserver/data/sunlight/light_removal.hpp"

using namespace terravox::sunlight;

namespace {

FlightLight light_with(const Sun& sun, float sky) {
    FlightLight out;
    out.sun = sun;
    out.sky = {sky, sky, sky};
    out.veil = {0.01F * sky, 0, 0};
    out.gain = {1 + sky, 1, 1};
    return out;
}

}  // namespace

TEST_CASE("the mean of one light is that light, bit for bit", "[sunlight][blend]") {
    const FlightLight one = light_with({359.7, 41.3}, 0.31F);
    const FlightLight mean = blended(std::array{WeightedLight{one, 0.3F}});
    CHECK(mean.sun->azimuth_deg == one.sun->azimuth_deg);
    CHECK(mean.sun->altitude_deg == one.sun->altitude_deg);
    CHECK(mean.sky == one.sky);
    CHECK(mean.veil == one.veil);
    CHECK(mean.gain == one.gain);
}

TEST_CASE("lights are averaged by their weights, suns as directions", "[sunlight][blend]") {
    const FlightLight west = light_with({358, 40}, 0.2F);
    const FlightLight east = light_with({2, 40}, 0.4F);
    const FlightLight equal = blended(std::array{WeightedLight{west, 2}, WeightedLight{east, 2}});
    const double azimuth_deg = equal.sun->azimuth_deg;
    CHECK(std::min(azimuth_deg, 360 - azimuth_deg) < 1e-6);
    CHECK(equal.sun->altitude_deg == Approx(40).margin(0.05));
    CHECK(equal.sky[1] == Approx(0.3));
    CHECK(equal.veil[0] == Approx(0.003));
    CHECK(equal.gain[0] == Approx(1.3));
    const FlightLight more_west =
        blended(std::array{WeightedLight{west, 3}, WeightedLight{east, 1}});
    CHECK(more_west.sky[2] == Approx(0.25));
    CHECK(more_west.sun->azimuth_deg == Approx(359).margin(0.01));
}

TEST_CASE("what is typical of a kind is averaged over those who know it", "[sunlight][blend]") {
    FlightLight a = light_with({150, 40}, 0.2F);
    FlightLight b = a;
    const auto roof = static_cast<std::size_t>(Kind::kRoof);
    const auto water = static_cast<std::size_t>(Kind::kWater);
    a.typical[roof] = 0.2F;
    b.typical[roof] = 0.4F;
    b.typical[water] = 0.05F;
    const FlightLight mean = blended(std::array{WeightedLight{a, 1}, WeightedLight{b, 1}});
    CHECK(mean.typical[roof] == Approx(0.3));
    CHECK(mean.typical[water] == Approx(0.05));
    CHECK(mean.typical[static_cast<std::size_t>(Kind::kGround)] == 0);
}

TEST_CASE("suns up to five degrees apart may be of one flight", "[sunlight][blend]") {
    CHECK(is_same_flight({359, 40}, {2, 41}));
    CHECK(is_same_flight({100, 70}, {112, 70}));  // that high, azimuths are close together
    CHECK_FALSE(is_same_flight({100, 20}, {112, 20}));
    CHECK_FALSE(is_same_flight({100, 40}, {100, 46}));
}

TEST_CASE("a field has its corners' levels, and changes linearly between them",
          "[sunlight][blend]") {
    const std::array<FlightLight, 4> corners{
        light_with({150, 40}, 0.1F), light_with({150, 40}, 0.2F), light_with({150, 40}, 0.3F),
        light_with({150, 40}, 0.8F)};
    const LightField field(corners[0], corners);
    CHECK(field.at(0, 0).sky[1] == Approx(0.1));
    CHECK(field.at(1, 0).sky[1] == Approx(0.2));
    CHECK(field.at(0, 1).sky[1] == Approx(0.3));
    CHECK(field.at(1, 1).sky[1] == Approx(0.8));
    CHECK(field.at(0.5F, 0.5F).sky[1] == Approx(0.35));
    CHECK(field.at(0.5F, 0).gain[0] == Approx(1.15));
    const LightField even(corners[3]);
    CHECK(even.at(0.37F, 0.81F).sky == corners[3].sky);
    CHECK(even.at(0.37F, 0.81F).gain == corners[3].gain);
}

TEST_CASE("sums over squares are those of their cells", "[voxelserver][sunlight]") {
    const int reach = GENERATE(1, 3, 4, 6);
    constexpr int kWidth = 23;
    constexpr int kHeight = 19;
    CAPTURE(reach);
    std::mt19937 random(7);
    std::vector<BrightCell> cells(static_cast<std::size_t>(kWidth) * kHeight);
    for (BrightCell& cell : cells) {
        cell.as = static_cast<BrightCell::As>(random() % 3);
        // Whole numbers, so that sums are exact in any order.
        cell.light = static_cast<float>(random() % 100);
    }
    const BrightnessAround around(kWidth, reach, cells);
    for (int z = reach; z < kHeight - reach; ++z)
        for (int x = reach; x < kWidth - reach; ++x) {
            BrightnessAround::Sums wanted;
            for (int dz = -reach; dz <= reach; ++dz)
                for (int dx = -reach; dx <= reach; ++dx) {
                    const BrightCell& cell =
                        cells[static_cast<std::size_t>((z + dz) * kWidth + x + dx)];
                    if (cell.as == BrightCell::As::kLit) {
                        wanted.lit += cell.light;
                        wanted.brightest_lit = std::max(wanted.brightest_lit, cell.light);
                        ++wanted.lit_count;
                    } else if (cell.as == BrightCell::As::kShadow) {
                        wanted.shadow += cell.light;
                        ++wanted.shadow_count;
                    }
                }
            const BrightnessAround::Sums found = around.at(x, z);
            CHECK(found.lit == wanted.lit);
            CHECK(found.brightest_lit == wanted.brightest_lit);
            CHECK(found.lit_count == wanted.lit_count);
            CHECK(found.shadow == wanted.shadow);
            CHECK(found.shadow_count == wanted.shadow_count);
        }
}
