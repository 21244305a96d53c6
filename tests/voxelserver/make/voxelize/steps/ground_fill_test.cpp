// The ground where none was seen: between points, under houses, in wide gaps.
#include <cmath>
#include <random>

#include "tests/catch.hpp"
#include "tests/same_bits.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"
#include "voxelserver/make/voxelize/steps/ground_fill.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

constexpr int kMargin = GroundHeights::kMargin;
using Wanted = Grid<char, kMargin>;
using HeightAt = std::function<double(std::int32_t x, std::int32_t z)>;  ///< NaN = no return

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();

MadeLand make_land(HeightAt height) {
    return MadeLand(
        [height = std::move(height)](std::int32_t x, std::int32_t z, MadeLand::Returns& out) {
            if (const double h = height(x, z); !std::isnan(h))
                out.push_back({h, kGroundClass});
        });
}

const AskWideGround kNeverAsked = [](std::int32_t x, std::int32_t z) -> float {
    FAIL("requested the ground of a wide gap at " << x << ", " << z);
    return 0;
};
const AskWideGround kFromAfar = [](std::int32_t x, std::int32_t z) {
    return static_cast<float>(1000 + x + 0.25 * z);
};

}  // namespace

TEST_CASE("columns with ground keep it, and those that need none get none",
          "[voxelserver][voxelize][ground]") {
    auto land =
        make_land([](auto x, auto z) { return dice(x, z, 1) < 0.4 ? kGap : 10 + 0.125 * x; });
    const Window window = land.window({0, 0});
    Wanted wanted;
    Wanted::each([&](int x, int z) { wanted.at(x, z) = x >= 30 ? 1 : 0; });
    const auto filled = fill_ground(window, wanted, kNeverAsked);
    const auto plain = seen_ground(window);
    GroundHeights::each([&](int x, int z) {
        const float own = window.column(x, z).ground.height;
        INFO("column " << x << ", " << z);
        REQUIRE(same_bits(plain.at(x, z), own));
        if (own == own || x < 30)
            REQUIRE(same_bits(filled.at(x, z), own));
        else
            REQUIRE_FALSE(std::isnan(filled.at(x, z)));
    });
}

TEST_CASE("ground between points and under houses lies on the plane around it",
          "[voxelserver][voxelize][ground]") {
    struct Plane {
        const char* name;
        double a;
        double b;
    };
    // max_off: voxels for each voxel of slope. The mean leans to the side that has more or nearer
    // ground: by less than two columns between points and under halls, by twice that in the corner
    // of an L.
    struct Gap {
        const char* name;
        HeightAt kept;
        double max_off;
    };
    const auto plane = GENERATE(values<Plane>({{"flat", 0, 0},
                                               {"sloping east", 0.25, 0},
                                               {"sloping both ways", -0.2, 0.4},
                                               {"steep", 0, 1}}));
    const auto gap = GENERATE(values<Gap>({
        {"no gap", [](auto, auto) { return 1.0; }, 0},
        {"single columns", [](auto x, auto z) { return x % 3 == 0 && z % 3 == 0 ? kGap : 1.0; },
         0.001},
        {"every second point lost", [](auto x, auto z) { return dice(x, z, 2) < 0.5 ? kGap : 1.0; },
         2},
        {"a hall of 20 x 12",
         [](auto x, auto z) { return x >= 10 && x < 30 && z >= 20 && z < 32 ? kGap : 1.0; }, 2},
        {"a row of houses across the border",
         [](auto x, auto z) { return z > 10 && z < 22 && x % 40 < 38 ? kGap : 1.0; }, 2},
        {"an L",
         [](auto x, auto z) {
             return x > 10 && x < 40 && z > 10 && z < 40 && (x < 20 || z < 20) ? kGap : 1.0;
         },
         4},
    }));
    DYNAMIC_SECTION(plane.name << ", " << gap.name) {
        const auto height = [&](double x, double z) { return 300 + plane.a * x + plane.b * z; };
        auto land = make_land([&](auto x, auto z) { return gap.kept(x, z) * height(x, z); });
        const auto filled = fill_ground(land.window({0, 0}), Wanted(1), kNeverAsked);
        const double steepness = std::hypot(plane.a, plane.b);
        double worst = 0;
        GroundHeights::each([&](int x, int z) {
            worst = std::max(worst, std::abs(filled.at(x, z) - height(x, z)));
        });
        INFO("worst " << worst << " voxels at a slope of " << steepness);
        CHECK(worst <= gap.max_off * steepness + 0.0005);  // heights are kept to 1/4096 voxel
    }
}

TEST_CASE("the ground of a wide gap is requested by absolute columns, and only beyond reach",
          "[voxelserver][voxelize][ground]") {
    constexpr grid::PatchKey kPatch{-3, 5};
    // No ground to the east of column 10 of the patch.
    auto land = make_land([&](auto x, auto) { return x < kPatch.x0() + 10 ? 50.0 : kGap; });
    int calls = 0;
    const auto filled = fill_ground(land.window(kPatch), Wanted(1),
                                    [&](auto x, auto z) { return ++calls, kFromAfar(x, z); });
    GroundHeights::each([&](int x, int z) {
        INFO("column " << x << ", " << z);
        const bool in_reach = x <= 9 + 32;
        if (in_reach)
            REQUIRE(std::abs(filled.at(x, z) - 50) < 1e-4f);
        else
            REQUIRE(filled.at(x, z) == kFromAfar(kPatch.x0() + x, kPatch.z0() + z));
    });
    CHECK(calls == (64 + kMargin - 42) * (64 + 2 * kMargin));
}

TEST_CASE("where nothing is known afar either, there is no ground",
          "[voxelserver][voxelize][ground]") {
    auto land = make_land([](auto, auto) { return kGap; });
    const auto filled =
        fill_ground(land.window({0, 0}), Wanted(1), [](auto, auto) { return kNoHeight; });
    CHECK(std::all_of(filled.values().begin(), filled.values().end(),
                      [](float h) { return std::isnan(h); }));
}
