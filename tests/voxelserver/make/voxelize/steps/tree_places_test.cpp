// Which tree a column's foliage belongs to.
#include <set>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"
#include "voxelserver/make/voxelize/steps/vegetation_fill.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

using Returns = MadeLand::Returns;

/// Cones of 8 columns across, 10 apart, with their tops in the middle.
MadeLand orchard() {
    return MadeLand([](int x, int z, Returns& out) {
        out.push_back({10.5, kGroundClass});
        const int dx = ((x % 10) + 10) % 10 - 5;
        const int dz = ((z % 10) + 10) % 10 - 5;
        const double off = std::hypot(dx, dz);
        if (off <= 4)
            out.push_back({22.5 - off, kTree});
    });
}

}  // namespace

TEST_CASE("foliage belongs to the tree whose top lies uphill", "[voxelserver][voxelize][trees]") {
    MadeLand land = orchard();
    const Window window = land.window({0, 0});
    TreePlaces trees(window, asprs(), 1);
    std::set<std::array<std::int32_t, 2>> tops;
    for (int z = 10; z < 60; ++z)
        for (int x = 10; x < 60; ++x)
            if (std::hypot(x % 10 - 5, z % 10 - 5) <= 4) {
                const auto top = trees.at(x, z);
                INFO(x << ", " << z);
                REQUIRE(top == std::array<std::int32_t, 2>{x / 10 * 10 + 5, z / 10 * 10 + 5});
                tops.insert(top);
            }
    CHECK(tops.size() == 25);
}

TEST_CASE("where no plants are around a column is its own place",
          "[voxelserver][voxelize][trees]") {
    MadeLand land([](int, int, Returns& out) { out.push_back({10.5, kGroundClass}); });
    const Window window = land.window({0, 0});
    TreePlaces trees(window, asprs(), 1);
    CHECK(trees.at(7, 9) == std::array<std::int32_t, 2>{7, 9});
}
