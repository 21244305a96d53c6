// Things that hang on nothing.
#include <optional>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"
#include "voxelserver/make/voxelize/steps/vegetation_fill.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

TEST_CASE("a voxel is isolated when nothing lies within two voxels sideways and three up and down",
          "[voxelserver][voxelize][isolated]") {
    struct Case {
        const char* name;
        int dx;
        int dz;
        int dy;
        std::uint8_t what;
        bool isolated;
    };
    const auto c = GENERATE(values<Case>({
        {"alone", 0, 0, 0, kTree, true},
        {"a return above", 0, 0, 3, kTree, false},
        {"a return far above", 0, 0, 4, kTree, true},
        {"a return below", 0, 0, -3, kTree, false},
        {"a return far below", 0, 0, -4, kTree, true},
        {"beside it", 1, 0, 0, kTree, false},
        {"two away", 2, 0, 0, kTree, false},
        {"three away", 3, 0, 0, kTree, true},
        {"the far corner", -2, 2, 3, kTree, false},
        {"beyond the far corner", -2, 3, 3, kTree, true},
        {"beyond the far corner's height", -2, 2, 4, kTree, true},
        {"a roof", 1, -2, -3, kBuilding, false},
        {"a deck", -1, 0, 2, kBridge, false},
        {"the ground", 0, 2, -2, kGroundClass, false},
        {"the ground far below", 0, 0, -20, kGroundClass, true},
        {"a wire", 0, -2, 1, kWire, false},
    }));
    // In the middle of a patch, and over its borders.
    const auto [x, z] = GENERATE(table<int, int>({{30, 30}, {-1, 64}}));
    DYNAMIC_SECTION(c.name << ", at " << x << " " << z) {
        MadeLand land(
            [&, px = x, pz = z](std::int32_t cx, std::int32_t cz, MadeLand::Returns& out) {
                if (cx == px && cz == pz)
                    out.push_back({50.5, kTree});
                if (cx == px + c.dx && cz == pz + c.dz && (c.dx != 0 || c.dz != 0 || c.dy != 0))
                    out.push_back({50.5 + c.dy, c.what});
            });
        CHECK(isolated(land.window({0, 0}), x, z, 50) == c.isolated);
    }
}

TEST_CASE("several returns in one voxel do not hold each other up",
          "[voxelserver][voxelize][isolated]") {
    MadeLand land([](std::int32_t x, std::int32_t z, MadeLand::Returns& out) {
        if (x == 9 && z == 9)
            out.insert(out.end(), {{50.1, kTree}, {50.5, kTree}, {50.9, kUnsorted}});
    });
    CHECK(isolated(land.window({0, 0}), 9, 9, 50));
}
