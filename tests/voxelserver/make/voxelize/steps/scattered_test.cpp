// Heights between scattered samples.
#include <algorithm>
#include <cmath>
#include <random>

#include "tests/catch.hpp"
#include "tests/same_bits.hpp"
#include "voxelserver/make/voxelize/steps/scattered.hpp"

using namespace terravox;
using terravox::test::same_bits;
using voxelize::ScatteredHeights;
using Sample = ScatteredHeights::Sample;

namespace {

std::vector<Sample> some_samples(unsigned seed, std::size_t count, bool on_a_grid) {
    std::mt19937 random(seed);
    std::vector<Sample> out;
    std::vector<std::pair<float, float>> taken;
    while (out.size() < count) {
        const auto place = [&] {
            return on_a_grid ? static_cast<float>(random() % 60)
                             : static_cast<float>(random() % 60'000) / 1000;
        };
        const std::pair at{place(), place()};
        if (std::find(taken.begin(), taken.end(), at) != taken.end())
            continue;
        taken.push_back(at);
        out.push_back({at.first, at.second, static_cast<float>(random() % 10'000) / 100});
    }
    return out;
}

}  // namespace

TEST_CASE("heights between samples do not depend on the order in which samples are given",
          "[voxelserver][voxelize][scattered]") {
    const bool on_a_grid = GENERATE(false, true);
    const unsigned seed = GENERATE(range(1u, 7u));
    auto samples = some_samples(seed, 5 + seed * 60, on_a_grid);
    const ScatteredHeights reference(samples);
    for (unsigned shuffle = 1; shuffle <= 4; ++shuffle) {
        std::shuffle(samples.begin(), samples.end(), std::mt19937(seed * 10 + shuffle));
        const ScatteredHeights other(samples);
        std::mt19937 random(seed);
        int different = 0;
        for (int i = 0; i < 500; ++i) {
            const float x = static_cast<float>(random() % 160) / 2 - 10;
            const float z = static_cast<float>(random() % 160) / 2 - 10;
            if (!same_bits(reference.at(x, z, 20), other.at(x, z, 20)) && ++different <= 3)
                UNSCOPED_INFO("seed " << seed << (on_a_grid ? ", on a grid" : "") << ", shuffle "
                                      << shuffle << ", at " << x << " " << z << ": "
                                      << reference.at(x, z, 20) << " and " << other.at(x, z, 20));
        }
        CHECK(different == 0);
    }
}

TEST_CASE("a sample's own place has its own height", "[voxelserver][voxelize][scattered]") {
    const auto samples = some_samples(3, 200, true);
    const ScatteredHeights heights(samples);
    for (const Sample& s : samples)
        CHECK(heights.at(s.x, s.z, 1) == s.height);
}

TEST_CASE("only samples within reach count", "[voxelserver][voxelize][scattered]") {
    struct Case {
        const char* name;
        std::vector<Sample> samples;
        float x;
        float z;
        float reach;
        float height;
    };
    constexpr float kNothing = -1;
    const auto c = GENERATE(values<Case>({
        {"one, near", {{0, 0, 7}}, 3, 4, 6, 7},
        {"one, at the reach's end", {{0, 0, 7}}, 3, 4, 5, 7},
        {"one, too far", {{0, 0, 7}}, 3, 4, 4.9f, kNothing},
        {"two, one too far", {{0, 0, 7}, {10, 0, 100}}, 1, 0, 5, 7},
        {"halfway between two", {{0, 0, 10}, {10, 0, 20}}, 5, 0, 50, 15},
        {"in the middle of four", {{0, 0, 1}, {2, 0, 2}, {0, 2, 3}, {2, 2, 6}}, 1, 1, 50, 3},
    }));
    DYNAMIC_SECTION(c.name) {
        const float found = ScatteredHeights(c.samples).at(c.x, c.z, c.reach);
        if (c.height == kNothing)
            CHECK(std::isnan(found));
        else
            CHECK(found == Approx(c.height));
    }
}

TEST_CASE("a mean never leaves the range of the samples around, and nearer ones weigh more",
          "[voxelserver][voxelize][scattered]") {
    const unsigned seed = GENERATE(1u, 2u, 3u);
    const auto samples = some_samples(seed, 300, false);
    const ScatteredHeights heights(samples);
    std::mt19937 random(seed);
    for (int i = 0; i < 500; ++i) {
        const float x = static_cast<float>(random() % 6000) / 100;
        const float z = static_cast<float>(random() % 6000) / 100;
        const float h = heights.at(x, z, 100);
        INFO("seed " << seed << ", at " << x << " " << z);
        CHECK((h >= 0 && h <= 100));
    }
    const ScatteredHeights two({{0, 0, 0}, {10, 0, 10}});
    for (float x = 0.5f; x < 9; x += 0.5f)
        CHECK(two.at(x, 0, 50) < two.at(x + 0.5f, 0, 50));
}

// More than are used may be equally far: which of them the tree takes must not matter.
TEST_CASE("a ring of more equally far samples than are used has one height in the middle",
          "[voxelserver][voxelize][scattered]") {
    // 20 places of a grid lie 25 from the origin.
    std::vector<Sample> ring;
    for (int x = -25; x <= 25; ++x)
        for (int z = -25; z <= 25; ++z)
            if (x * x + z * z == 625)
                ring.push_back({static_cast<float>(x), static_cast<float>(z),
                                static_cast<float>(x + 3 * static_cast<int>(ring.size()))});
    REQUIRE(ring.size() == 20);
    const float reference = ScatteredHeights(ring).at(0, 0, 32);
    for (unsigned shuffle = 1; shuffle <= 10; ++shuffle) {
        std::shuffle(ring.begin(), ring.end(), std::mt19937(shuffle));
        INFO("shuffle " << shuffle);
        CHECK(same_bits(ScatteredHeights(ring).at(0, 0, 32), reference));
    }
}
