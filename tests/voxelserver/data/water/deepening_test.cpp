#include "voxelserver/data/water/deepening.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using namespace terravox::water;

namespace {

struct Mask {
    int width;
    int height;
    std::vector<std::uint8_t> water;
};

Mask random_mask(std::mt19937& random) {
    Mask m{1 + static_cast<int>(random() % 40), 1 + static_cast<int>(random() % 40), {}};
    const unsigned dry = 1 + random() % 60;
    for (int i = 0; i < m.width * m.height; ++i)
        m.water.push_back(random() % (dry * dry) == 0 ? 0 : 1);
    return m;
}

float slow_distance(const Mask& m, int x, int z, int reach) {
    int best = reach * reach;
    for (int v = 0; v < m.height; ++v)
        for (int u = 0; u < m.width; ++u)
            if (m.water[static_cast<std::size_t>(v * m.width + u)] == 0)
                best = std::min(best, (u - x) * (u - x) + (v - z) * (v - z));
    return static_cast<float>(std::sqrt(static_cast<double>(best)));
}

}  // namespace

TEST_CASE("shore distance is the distance to the nearest dry column, exactly, up to the reach",
          "[water][deepening]") {
    const auto seed = GENERATE(range(1u, 40u));
    std::mt19937 random(seed);
    const Mask m = random_mask(random);
    const int reach = 1 + static_cast<int>(random() % 50);
    const std::vector<float> found = shore_distance(m.water, m.width, m.height, reach);
    INFO("seed " << seed << ", " << m.width << " x " << m.height << ", reach " << reach);
    for (int z = 0; z < m.height; ++z)
        for (int x = 0; x < m.width; ++x) {
            INFO("column " << x << ", " << z);
            REQUIRE(found[static_cast<std::size_t>(z * m.width + x)] ==
                    slow_distance(m, x, z, reach));
        }
}

TEST_CASE("depth grows from the waterline by the slope, between its bounds", "[water][deepening]") {
    struct Case {
        const char* name;
        float distance;
        double voxel_m;
        float depth;
    };
    const auto c = GENERATE(values<Case>({
        {"dry", 0, 1, 0},
        {"next to the shore", 1, 1, 0.2f},
        {"five and a half metres from the waterline", 6, 1, 1.65f},
        {"the same in small voxels", 22.5f, 0.25, 1.65f},
        {"far out", 1000, 1, 4},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK(depth_m(c.distance, c.voxel_m, {0.3, 0.2, 4, 32}) == Approx(c.depth));
    }
}

TEST_CASE("deepening refuses what it cannot mean", "[water][deepening]") {
    const std::vector<std::uint8_t> mask(6, 1);
    CHECK(shore_distance({}, 0, 5, 3).empty());
    CHECK_THROWS_WITH(shore_distance(mask, 2, 2, 3),
                      test::contains("6 columns") && test::contains("2 x 2"));
    CHECK_THROWS_AS(shore_distance(mask, -2, -3, 3), util::Error);
    CHECK_THROWS_WITH(shore_distance(mask, 3, 2, 0), test::contains("1 to 1024"));
    CHECK_THROWS_AS(depths_m(mask, 3, 2, 1, {-1, 0, 1, 4}), util::Error);
    CHECK_THROWS_AS(depths_m(mask, 3, 2, 1, {0.3, 2, 1, 4}), util::Error);
    CHECK_THROWS_AS(depths_m(mask, 3, 2, 0, {0.3, 0, 1, 4}), util::Error);
    CHECK(depths_m(mask, 3, 2, 1, {0.3, 0, 9, 4}) ==
          std::vector<float>(6, depth_m(4, 1, {0.3, 0, 9, 4})));  // no shore within reach
}
