#include <algorithm>
#include <cmath>
#include <random>

#include "tests/catch.hpp"
#include "tests/common/voxel/material_grid.hpp"

using namespace terravox::voxel;
using terravox::test::light_reaches;
using terravox::test::make_level;
using terravox::test::MaterialGrid;
using terravox::test::opaque_at;
using terravox::test::open_columns;
using enum terravox::voxel::Material;

namespace {

constexpr std::array kShells = {kWall, kRoof, kOrangeRoof, kGreyRoof, kFlatRoof, kBridge, kTower};
constexpr std::array kTerrains = {kRock,     kSoil, kGround, kGrass, kRoad,
                                  kConcrete, kRail, kSand,   kSnow};
constexpr std::array kLight = {kAir, kWater, kLowVegetation, kHighVegetation, kWire};

struct Random {
    std::mt19937 engine;
    int in(int low, int high) {
        return low + static_cast<int>(engine() % static_cast<unsigned>(high - low));
    }
    template <class Array>
    Material of(const Array& materials) {
        return materials[engine() % materials.size()];
    }
};

template <class Each>
void for_columns(const Each& each) {
    for (int x = 0; x < 64; ++x)
        for (int z = 0; z < 64; ++z)
            each(x, z);
}

// Walls around, a roof on top, at every parity; the ground is `floor_y` high.
MaterialGrid house(int x0, int y0, int z0, int thick) {
    MaterialGrid grid;
    grid.fill({0, 64}, {0, y0}, {0, 64}, kGround);
    grid.fill({x0, x0 + 33}, {y0, y0 + 29}, {z0, z0 + 33}, kWall);
    grid.fill({x0, x0 + 33}, {y0 + 29 - thick, y0 + 29}, {z0, z0 + 33}, kRoof);
    grid.fill({x0 + thick, x0 + 33 - thick}, {y0, y0 + 29 - thick}, {z0 + thick, z0 + 33 - thick},
              kAir);
    return grid;
}

}  // namespace

TEST_CASE("coarse opaque voxels cover every wall, roof, bridge and tower",
          "[common][voxel][levels]") {
    const auto seed = GENERATE(range(1u, 5u));
    INFO("seed " << seed);
    Random random{std::mt19937(seed)};
    MaterialGrid grid;
    for (int i = 0; i < 40'000; ++i) {
        const Material m = i % 5 == 0  ? random.of(kShells)
                           : i % 5 < 3 ? random.of(kLight)
                                       : random.of(kTerrains);
        grid.set(random.in(0, 64), random.in(0, 256), random.in(0, 64), m);
    }
    const auto box = make_level(grid.build(), 1);
    int shells = 0;
    int lost = 0;
    for_columns([&](int x, int z) {
        for (int y = 0; y < 256; ++y) {
            if (std::find(kShells.begin(), kShells.end(), grid.at(x, y, z)) == kShells.end())
                continue;
            ++shells;
            lost += !opaque_at(*box, x >> 1, y >> 1, z >> 1);
        }
    });
    CHECK(shells > 5000);
    CHECK(lost == 0);
}

TEST_CASE("no light gets into a closed house at any level", "[common][voxel][levels]") {
    const int shift = GENERATE(range(0, 8));
    const int thick = GENERATE(1, 2);
    INFO("shift " << shift << ", walls " << thick << " thick");
    const auto fine =
        house(12 + (shift & 1), 40 + (shift >> 1 & 1), 10 + (shift >> 2), thick).build();
    REQUIRE(!light_reaches(*fine, 64, 256, {30, 50, 28}));
    for (int level = 1; level <= 3; ++level) {
        INFO("level " << level);
        const auto box = make_level(fine, level);
        REQUIRE(
            !opaque_at(*box, 30 >> level, 50 >> level, 28 >> level));  // there is still an inside
        CHECK(!light_reaches(*box, 64 >> level, 256 >> level,
                             {30 >> level, 50 >> level, 28 >> level}));
    }
}

TEST_CASE("a diagonal wall, one voxel wide, keeps both sides apart", "[common][voxel][levels]") {
    struct Case {
        const char* name;
        int sign;
        int offset;
    };
    const auto c = GENERATE(values<Case>(
        {{"x = z", 1, 0}, {"x = z + 1", 1, 1}, {"x = 63 - z", -1, 63}, {"x = 62 - z", -1, 62}}));
    const auto material = GENERATE(kWall, kBridge);
    DYNAMIC_SECTION(c.name << " of " << material_name(material)) {
        // A pen of straight walls with the diagonal through it and a lid on one half: light must
        // stay on the other.
        MaterialGrid grid;
        const auto beyond = [&](int x, int z) {
            return c.sign * z + c.offset - x;
        };  // 0 on the wall
        for_columns([&](int x, int z) {
            grid.fill({x, x + 1}, {0, 2}, {z, z + 1}, kRock);
            if (beyond(x, z) == 0)
                grid.fill({x, x + 1}, {2, 40}, {z, z + 1}, material);
            if (x == 0 || z == 0 || x == 63 || z == 63)
                grid.fill({x, x + 1}, {2, 40}, {z, z + 1}, kWall);
            if (beyond(x, z) > 0)
                grid.set(x, 39, z, kRoof);
        });
        const int dark_x = 8;
        const int dark_z = c.sign > 0 ? 50 : 8;
        REQUIRE(beyond(dark_x, dark_z) > 0);
        for (int level = 0; level <= 2; ++level) {
            INFO("level " << level);
            const auto box = make_level(grid.build(), level);
            REQUIRE(!opaque_at(*box, dark_x >> level, 20 >> level, dark_z >> level));
            CHECK(!light_reaches(*box, 64 >> level, 256 >> level,
                                 {dark_x >> level, 20 >> level, dark_z >> level}));
        }
    }
}

TEST_CASE("what blocks every vertical line goes on blocking it, level by level",
          "[common][voxel][levels]") {
    struct Case {
        const char* name;
        void (*column)(Random&, MaterialGrid&, int x, int z);
    };
    const auto c = GENERATE(values<Case>({
        {"lone shells at any height", [](Random& r, MaterialGrid& g, int x,
                                         int z) { g.set(x, r.in(0, 256), z, r.of(kShells)); }},
        {"lone objects at any height",
         [](Random& r, MaterialGrid& g, int x, int z) {
             g.set(x, r.in(0, 256), z, r.in(0, 2) == 0 ? kObject : kUnknown);
         }},
        {"shells and objects",
         [](Random& r, MaterialGrid& g, int x, int z) {
             g.set(x, r.in(0, 256), z, r.in(0, 2) == 0 ? r.of(kShells) : kObject);
         }},
        {"jagged terrain",
         [](Random& r, MaterialGrid& g, int x, int z) {
             g.fill({x, x + 1}, {7, r.in(8, 200)}, {z, z + 1}, r.of(kTerrains));
         }},
        {"terrain, water on it, things above",
         [](Random& r, MaterialGrid& g, int x, int z) {
             const int top = r.in(7, 60);
             g.fill({x, x + 1}, {5, top}, {z, z + 1}, r.of(kTerrains));
             g.fill({x, x + 1}, {top, top + r.in(0, 9)}, {z, z + 1}, kWater);
             g.set(x, r.in(80, 256), z, r.in(0, 3) == 0 ? r.of(kShells) : r.of(kLight));
         }},
    }));
    const auto seed = GENERATE(range(1u, 3u));
    DYNAMIC_SECTION(c.name << ", seed " << seed) {
        Random random{std::mt19937(seed)};
        MaterialGrid grid;
        for_columns([&](int x, int z) { c.column(random, grid, x, z); });
        auto box = grid.build();
        REQUIRE(open_columns(*box, 0) == 0);
        for (int level = 1; level <= 5; ++level) {
            box = downsample({level, 0, 0, 0}, terravox::test::alone(box));
            INFO("level " << level);
            CHECK(open_columns(*box, level) == 0);
        }
    }
}

TEST_CASE("a thin sheet of terrain without steps of two stays closed", "[common][voxel][levels]") {
    const auto seed = GENERATE(range(1u, 13u));
    INFO("seed " << seed);
    Random random{std::mt19937(seed)};
    // Steps of at most one between neighbours: the sum of two walks would step by two, a least
    // upper bound of cones does not.
    struct Cone {
        int x;
        int z;
        int y;
    };
    std::vector<Cone> cones(30);
    for (Cone& cone : cones)
        cone = {random.in(0, 64), random.in(0, 64), random.in(60, 110)};
    MaterialGrid grid;
    for_columns([&](int x, int z) {
        int y = 1000;
        for (const Cone& cone : cones)
            y = std::min(y, cone.y + std::abs(x - cone.x) + std::abs(z - cone.z));
        grid.set(x, y, z, random.of(kTerrains));
    });
    CHECK(open_columns(*make_level(grid.build(), 0), 0) == 0);
    CHECK(open_columns(*make_level(grid.build(), 1), 1) == 0);
}

TEST_CASE("an opaque voxel that a free neighbour shows has attributes", "[common][voxel][levels]") {
    const auto seed = GENERATE(range(1u, 7u));
    INFO("seed " << seed);
    Random random{std::mt19937(seed)};
    MaterialGrid grid;
    for_columns([&](int x, int z) {
        grid.fill({x, x + 1}, {0, 40 + x / 3 + random.in(0, 9)}, {z, z + 1}, kGrass);
        if (random.in(0, 9) == 0)
            grid.fill({x, x + 1}, {60, 60 + random.in(1, 30)}, {z, z + 1}, kHighVegetation);
    });
    for (int i = 0; i < 12; ++i) {
        const int x = random.in(0, 50);
        const int z = random.in(0, 50);
        const int y = random.in(10, 90);
        grid.fill({x, x + random.in(1, 14)}, {y, y + random.in(1, 20)}, {z, z + random.in(1, 14)},
                  i % 3 == 0 ? kAir : random.of(kShells));
    }
    auto box = grid.build();
    for (int level = 1; level <= 4; ++level) {
        box = downsample({level, 0, 0, 0}, terravox::test::alone(box));
        const int side = 64 >> level;
        const int height = 256 >> level;
        int bare = 0;
        for (int x = 0; x < side; ++x)
            for (int z = 0; z < side; ++z)
                for (int y = 1; y < height; ++y) {
                    if (box->voxel(x, y, z) != VoxelAttr{})
                        continue;
                    const auto open = [&](int i, int j, int k) {
                        return i < 0 || k < 0 || i >= side || k >= side || j >= height ||
                               !opaque_at(*box, i, j, k);
                    };
                    bare += open(x - 1, y, z) || open(x + 1, y, z) || open(x, y - 1, z) ||
                            open(x, y + 1, z) || open(x, y, z - 1) || open(x, y, z + 1);
                }
        INFO("level " << level);
        CHECK(bare == 0);
    }
}
