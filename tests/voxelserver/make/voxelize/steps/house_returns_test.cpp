// Returns beside and above houses: of the house, or of plants.
#include "voxelserver/make/voxelize/steps/house_returns.hpp"

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

using Part = HouseReturns::Part;
constexpr double kGround = 10.5;
constexpr double kRoof = 22.5;

/// A house of x < 30, or in voxels of half a metre, and one return beside or above it.
Part part_of(int x, int z, double height, std::uint8_t code, double voxel_m,
             const MadeLand::ReturnsAt& others = nullptr) {
    MadeLand land([&](int cx, int cz, MadeLand::Returns& out) {
        if (cx < 30)
            out.push_back({kRoof, kBuilding});
        else
            out.push_back({kGround, kGroundClass});
        if (cx == x && cz == z)
            out.push_back({height, code});
        if (others)
            others(cx, cz, out);
    });
    const Window window = land.window({0, 0});
    const GroundHeights ground(static_cast<float>(kGround));
    const HouseReturns houses(window, asprs(), ground, {}, voxel_m);
    ObjectVoxel o;
    o.y = static_cast<std::int32_t>(std::floor(height));
    o.source_class = code;
    return houses.part(x, z, o);
}

}  // namespace

TEST_CASE("returns close to a wall and below its roof are the wall's; those above, the roof's",
          "[voxelserver][voxelize][vegetation]") {
    struct Case {
        const char* name;
        int x;
        double height;
        std::uint8_t code;
        double voxel_m;
        Part part;
    };
    const auto c = GENERATE(values<Case>({
        {"unclassified, before the wall", 30, 15, kUnsorted, 1, Part::kWall},
        {"at the edge of the roof", 30, 23, kUnsorted, 1, Part::kWall},
        {"low, at the foot of the wall", 30, 12, kUnsorted, 1, Part::kWall},
        {"higher than the roof", 30, 24, kUnsorted, 1, Part::kNone},
        {"two metres before the wall", 31, 15, kUnsorted, 1, Part::kNone},
        {"a metre before it, in half metres", 31, 15, kUnsorted, 0.5, Part::kWall},
        {"farther, in half metres", 32, 15, kUnsorted, 0.5, Part::kNone},
        {"beside it, in voxels of 1.5 m", 30, 15, kUnsorted, 1.5, Part::kWall},
        {"beside it, where voxels are wider than that", 30, 15, kUnsorted, 1.6, Part::kNone},
        {"beside it, in voxels of 5 m", 30, 15, kUnsorted, 5, Part::kNone},
        {"the same, as high as the roof", 30, 22, kUnsorted, 5, Part::kNone},
        {"in the house's own column of 5 m", 20, 15, kUnsorted, 5, Part::kOnRoof},
        {"above it", 20, 24, kUnsorted, 5, Part::kNone},
        {"a metre before it, in voxels of 0.1 m", 39, 15, kUnsorted, 0.1, Part::kWall},
        {"farther, in voxels of 0.1 m", 40, 15, kUnsorted, 0.1, Part::kNone},
        {"ten voxels before it, in voxels of 5 cm", 39, 15, kUnsorted, 0.05, Part::kWall},
        {"eleven before it", 40, 15, kUnsorted, 0.05, Part::kNone},
        {"of a plant's class, a strip on the wall", 30, 15, kTree, 1, Part::kWall},
        {"a shrub at the foot of the wall", 30, 12, kTree, 1, Part::kNone},
        {"a wire before the wall", 30, 15, kWire, 1, Part::kNone},
        {"unclassified, on the roof", 20, 24, kUnsorted, 1, Part::kOnRoof},
        {"far above the roof", 20, 26, kUnsorted, 1, Part::kNone},
        {"a tree on the roof", 20, 24, kTree, 1, Part::kNone},
    }));
    // In the middle of a patch, and over its border.
    const int z = GENERATE(20, 63, 64);
    DYNAMIC_SECTION(c.name << ", at " << z) {
        CHECK(part_of(c.x, z, c.height, c.code, c.voxel_m) == c.part);
    }
}

TEST_CASE("foliage that stands free beside a house is a tree up to its wall and over its roof",
          "[voxelserver][voxelize][vegetation]") {
    struct Case {
        const char* name;
        int x;
        double height;
        std::uint8_t code;
        Part part;
    };
    const auto c = GENERATE(values<Case>({
        {"of a plant's class at the wall", 30, 17, kTree, Part::kNone},
        {"the same, far below the foliage", 30, 14, kTree, Part::kWall},
        {"unclassified at the wall", 30, 17, kUnsorted, Part::kWall},
        {"unclassified over the roof's edge", 29, 25, kUnsorted, Part::kNone},
        {"unclassified, farther in", 27, 25, kUnsorted, Part::kOnRoof},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto tree = [&](int cx, int, MadeLand::Returns& out) {
            if (cx == 31)
                out.insert(out.end(), {{18.5, kTree}, {24.5, kTree}});
        };
        CHECK(part_of(c.x, 20, c.height, c.code, 1, tree) == c.part);
    }
}

TEST_CASE("a gap between the points of a roof is roof", "[voxelserver][voxelize][vegetation]") {
    const auto part = [](double height) {
        MadeLand land([&](int x, int z, MadeLand::Returns& out) {
            if (x == 20 && z == 20)
                out.push_back({height, kUnsorted});
            else
                out.push_back({kRoof, kBuilding});
        });
        const Window window = land.window({0, 0});
        const GroundHeights ground(static_cast<float>(kGround));
        ObjectVoxel o;
        o.y = static_cast<std::int32_t>(height);
        o.source_class = kUnsorted;
        return HouseReturns(window, asprs(), ground, {}, 1).part(20, 20, o);
    };
    CHECK(part(22.5) == Part::kWall);
    CHECK(part(24.5) == Part::kOnRoof);
}
