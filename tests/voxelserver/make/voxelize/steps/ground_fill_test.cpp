// The ground where none was seen: between points, under houses, in wide gaps.
// Which columns belong to the survey: gaps between points do, wide voids do not.
#include <algorithm>
#include <cmath>
#include <functional>

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

using Bounds = Grid<char, Window::kMargin>;
using InMask = std::function<bool(int x, int z)>;

Window find_window(const InMask& occupied) {
    return MadeLand([&](std::int32_t x, std::int32_t z, MadeLand::Returns& out) {
               if (occupied(x, z))
                   out.push_back({10, kGroundClass});
           })
        .window({0, 0});
}

Bounds measure_bounds(const InMask& inside) {
    Bounds out;
    Bounds::each([&](int x, int z) { out.at(x, z) = inside(x, z) ? 1 : 0; });
    return out;
}

constexpr int kRim = 2;  // of water cells two columns wide, as MadeLand makes them

const InMask kEverywhere = [](int, int) { return true; };

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

TEST_CASE("a void is closed up to twice the radius, and open when wider",
          "[voxelserver][voxelize][coverage]") {
    struct Case {
        const char* name;
        int radius;
        int x0;
        int z0;
        int wide;
        int deep;
        bool open;
    };
    const auto c = GENERATE(values<Case>({
        {"twice the radius", 8, 20, 20, 16, 16, false},
        {"one more", 8, 20, 20, 17, 17, true},
        {"long and narrow: a street", 8, -64, 20, 192, 16, false},
        {"long and a column wider", 8, -64, 20, 192, 17, true},
        {"across the patch's corner", 8, -10, -10, 20, 20, true},
        {"the greatest radius", 28, 0, 0, 56, 56, false},
        {"one more", 28, 0, 0, 57, 57, true},
    }));
    DYNAMIC_SECTION(c.name << ", radius " << c.radius) {
        const auto in_void = [&](int x, int z) {
            return x >= c.x0 && x < c.x0 + c.wide && z >= c.z0 && z < c.z0 + c.deep;
        };
        const Window window = find_window([&](int x, int z) { return !in_void(x, z); });
        const auto covered = find_coverage(window, measure_bounds(kEverywhere), c.radius);
        int wrong = 0;
        Margined<char>::each([&](int x, int z) {
            wrong += (covered.at(x, z) != 0) == (c.open && in_void(x, z)) ? 1 : 0;
        });
        CHECK(wrong == 0);
    }
}

TEST_CASE("the rim of a survey has no fringe, and lone points stay",
          "[voxelserver][voxelize][coverage]") {
    // The survey ends at z = 20, but for a column in five, which goes on to z = 24.
    const auto in_bounds = [](int x, int) { return x < 60; };
    const auto is_survey = [](int x, int z) { return z < (x % 5 == 0 ? 24 : 20); };
    const auto is_lone = [](int x, int z) { return x == 40 && z == 50; };
    Coverage covered(0);
    Coverage::each([&](int x, int z) {
        covered.at(x, z) = in_bounds(x, z) && (is_survey(x, z) || is_lone(x, z)) ? 1 : 0;
    });
    const auto cut = straighten_rim(covered, measure_bounds(in_bounds), kWidestRim);
    int wrong = 0;
    Margined<char>::each([&](int x, int z) {
        const bool expected = in_bounds(x, z) && (z < 20 || is_lone(x, z));
        // Which of two rows the straight edge runs along is left open.
        wrong += z != 20 && (cut.at(x, z) != 0) != expected ? 1 : 0;
    });
    CHECK(wrong == 0);
    CHECK(straighten_rim(covered, measure_bounds(in_bounds), 0).at(40, 23) == 1);
}

TEST_CASE("a void at the survey's edge closes only between returns along the edge",
          "[voxelserver][voxelize][coverage]") {
    constexpr int kNorth = 5;
    // The bounds' western edge lies at x = 10, the northern one at z = 5; the void begins there and
    // is `deep` and `wide` columns large.
    const auto inside = [](int x, int z) { return x >= 10 && z >= kNorth && x < 100; };
    struct Case {
        const char* name;
        int x0;
        int z0;
        int deep;
        int wide;
        bool open;
    };
    const auto c = GENERATE(values<Case>({
        {"as wide as a gap may be", 10, 10, 8, 16, false},
        {"deep, but between returns", 10, 10, 60, 16, false},
        {"wider", 10, 10, 8, 17, true},
        {"wider, and hardly deep: the rim", 10, 10, kRim, 40, false},
        {"wider, and hardly deep, all along the edge", 10, kNorth, kRim, 123, false},
        {"deeper than the rim, all along the edge", 10, kNorth, 20, 123, true},
        {"in the corner", 10, kNorth, 12, 12, true},
        {"in the corner, no larger than the rim", 10, kNorth, kRim, kRim, false},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto in_void = [&](int x, int z) {
            return x >= c.x0 && x < c.x0 + c.deep && z >= c.z0 && z < c.z0 + c.wide;
        };
        const auto covered =
            find_coverage(find_window([&](int x, int z) { return inside(x, z) && !in_void(x, z); }),
                          measure_bounds(inside), 8);
        // Beside returns a void of this size keeps at most twice the rim.
        const auto deep_in_void = [&](int x, int z) {
            for (int d = 0; d <= 2 * kRim; ++d)
                if (!in_void(x + d, z) || !in_void(x, z + d) ||
                    !in_void(x, std::max(z - d, kNorth)))
                    return false;
            return true;
        };
        int lost = 0;
        int spurious = 0;
        int left = 0;
        Margined<char>::each([&](int x, int z) {
            const bool is_covered = covered.at(x, z) != 0;
            lost += inside(x, z) && !(c.open && in_void(x, z)) && !is_covered ? 1 : 0;
            spurious += is_covered && (!inside(x, z) || (c.open && deep_in_void(x, z))) ? 1 : 0;
            left += c.open && inside(x, z) && !is_covered ? 1 : 0;
        });
        CHECK(lost == 0);
        CHECK(spurious == 0);
        CHECK((left > 0) == c.open);
    }
}
