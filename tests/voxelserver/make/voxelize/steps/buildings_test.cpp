// Which roofs are one building, and that all patches agree about it.
#include "voxelserver/make/voxelize/steps/buildings.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

using Returns = MadeLand::Returns;

/// Columns [x0, x1) x [z0, z1) with a roof of this height.
struct House {
    int x0, z0, x1, z1;
    double height;
};

MadeLand town(std::vector<House> houses) {
    return MadeLand([houses = std::move(houses)](int x, int z, Returns& out) {
        for (const House& h : houses)
            if (x >= h.x0 && x < h.x1 && z >= h.z0 && z < h.z1) {
                out.push_back({h.height, kBuilding});
                return;
            }
        out.push_back({10.5, kGroundClass});
    });
}

}  // namespace

TEST_CASE("a house is one building, named by its first column, and another is another",
          "[voxelserver][voxelize][buildings]") {
    MadeLand land = town({{5, 6, 12, 20, 18.5}, {20, 6, 30, 20, 18.5}});
    const Buildings found(land.window({0, 0}), 1);
    const Building* first = found.at(6, 7);
    const Building* second = found.at(29, 19);
    REQUIRE(first != nullptr);
    REQUIRE(second != nullptr);
    CHECK(first != second);
    CHECK(first->x == 5);
    CHECK(first->z == 6);
    CHECK(first->columns == 7 * 14);
    CHECK(found.at(11, 19) == first);
    CHECK(found.at(15, 10) == nullptr);
}

TEST_CASE("a step between roofs parts buildings, a single column without returns does not",
          "[voxelserver][voxelize][buildings]") {
    MadeLand land = town({{5, 6, 12, 20, 18.5}, {12, 6, 20, 20, 24.5}});
    const Buildings apart(land.window({0, 0}), 1);
    CHECK(apart.at(11, 10) != apart.at(12, 10));
    MadeLand gap = town({{5, 6, 12, 20, 18.5}, {13, 6, 20, 20, 18.5}});
    const Buildings joined(gap.window({0, 0}), 1);
    CHECK(joined.at(11, 10) == joined.at(13, 10));
}

TEST_CASE("patches agree about the building that crosses their edge, however wide it is",
          "[voxelserver][voxelize][buildings]") {
    const int width = GENERATE(2, 47, 48, 64, 200);
    const int from = GENERATE(63, 40, 17);
    INFO(width << " columns from " << from);
    MadeLand land = town({{from, 40, from + width, 80, 18.5}});
    const auto number = [&](grid::PatchKey patch, int x, int z) {
        const Buildings found(land.window(patch), 1);
        const Building* b = found.at(x - patch.x0(), z - patch.z0());
        return b == nullptr ? std::string("none")
                            : std::to_string(b->x) + "," + std::to_string(b->z) + "," +
                                  std::to_string(b->columns);
    };
    const std::string wanted = width <= Buildings::kWidest
                                   ? std::to_string(from) + ",40," + std::to_string(width * 40)
                                   : "none";
    for (int x = from; x < from + width; x += 7)
        for (const int z : {40, 63, 64, 79})
            REQUIRE(number({x >> 6, z >> 6}, x, z) == wanted);
}
