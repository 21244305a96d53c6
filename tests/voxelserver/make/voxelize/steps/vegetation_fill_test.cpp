// Crowns and trunks.
// Which tree a column's foliage belongs to; things that hang on nothing.
#include <cmath>
#include <optional>
#include <set>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"
#include "voxelserver/make/voxelize/steps/vegetation_fill.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

using Returns = MadeLand::Returns;
constexpr double kGround = 10.5;

Margined<Crown> find_crowns(MadeLand& land, grid::PatchKey patch = {0, 0}, double voxel_m = 1,
                            const Settings& settings = {}) {
    return fill_crowns(land.window(patch), asprs(), GroundHeights(static_cast<float>(kGround)),
                       settings, voxel_m);
}

/// A crown like a cone over its middle, without returns of the ground below. @return NaN outside
double cone(double x, double z, double mid_x, double mid_z, double top, double radius) {
    const double d = std::hypot(x - mid_x, z - mid_z);
    return d > radius ? std::numeric_limits<double>::quiet_NaN() : top - d;
}

void put(Returns& out, double crown) {
    if (std::isnan(crown))
        out.push_back({kGround, kGroundClass});
    else
        out.push_back({crown, kTree});
}

std::string to_text(const std::vector<std::pair<int, int>>& columns) {
    std::string out;
    for (const auto& [x, z] : columns)
        out += " (" + std::to_string(x) + ", " + std::to_string(z) + ")";
    return out;
}

/// Trunks in the patches around the origin, each counted in its own patch.
std::vector<std::pair<int, int>> find_trunks(MadeLand& land, double voxel_m = 1) {
    std::vector<std::pair<int, int>> out;
    for (int pz = -1; pz <= 1; ++pz)
        for (int px = -1; px <= 1; ++px) {
            const auto crowns = find_crowns(land, {px, pz}, voxel_m);
            for (int z = 0; z < 64; ++z)
                for (int x = 0; x < 64; ++x)
                    if (crowns.at(x, z).trunk)
                        out.emplace_back(px * 64 + x, pz * 64 + z);
        }
    return out;
}

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

TEST_CASE(
    "a column without returns among crown columns is closed, unless something else was seen in it",
    "[voxelserver][voxelize][vegetation]") {
    struct Case {
        const char* name;
        int code;
        bool closed;
    };
    constexpr int kNothing = -1;
    const auto c = GENERATE(values<Case>({{"no return", kNothing, true},
                                          {"the ground", kGroundClass, false},
                                          {"a roof", kBuilding, false},
                                          {"water", kWater, false},
                                          {"a deck", kBridge, false}}));
    DYNAMIC_SECTION(c.name) {
        MadeLand land([&](int x, int z, Returns& out) {
            if (x != 31 || z != 30)
                put(out, cone(x, z, 30, 30, 25.5, 5));
            else if (c.code != kNothing)
                out.push_back({kGround, static_cast<std::uint8_t>(c.code)});
        });
        const auto crowns = find_crowns(land);
        CHECK(crowns.at(31, 30).seen() == c.closed);
        if (c.closed)
            CHECK((crowns.at(31, 30).top >= 23 && crowns.at(31, 30).top <= 25 &&
                   crowns.at(31, 30).top_voxel.source_class == kTree));
        CHECK_FALSE(crowns.at(37, 30).seen());
    }
}

TEST_CASE("only plants higher than a shrub have crowns", "[voxelserver][voxelize][vegetation]") {
    struct Case {
        const char* name;
        double above_m;
        double voxel_m;
        std::uint8_t code;
        bool crown;
    };
    const auto c = GENERATE(values<Case>({
        {"a tree", 12, 1, kTree, true},
        {"a shrub", 1.5, 1, kTree, false},
        {"a tall unsorted thing", 12, 1, kUnsorted, true},
        {"a mast", 12, 1, 15, false},
        {"a tree in half metres", 6, 0.5, kTree, true},
        {"a shrub in half metres", 1.5, 0.5, kTree, false},
    }));
    DYNAMIC_SECTION(c.name) {
        MadeLand land([&](int x, int z, Returns& out) {
            if (std::hypot(x - 30, z - 30) > 3)
                out.push_back({kGround, kGroundClass});
            else
                out.push_back({kGround + c.above_m / c.voxel_m, c.code});
        });
        const auto crowns = find_crowns(land, {0, 0}, c.voxel_m);
        Margined<Crown>::each([&](int x, int z) {
            REQUIRE(crowns.at(x, z).seen() == (c.crown && std::hypot(x - 30, z - 30) <= 3));
        });
    }
}

TEST_CASE("a bird is no crown", "[voxelserver][voxelize][vegetation]") {
    MadeLand land([](int x, int z, Returns& out) {
        out.push_back({kGround, kGroundClass});
        if (x == 20 && z == 20)
            out.push_back({60, kTree});
    });
    for (const bool drop : {true, false}) {
        Settings settings;
        settings.points.drop_isolated = drop;
        CHECK(find_crowns(land, {0, 0}, 1, settings).at(20, 20).seen() == !drop);
    }
}

TEST_CASE("a crown is one body: foliage reaches down to lower neighbours' tops",
          "[voxelserver][voxelize][vegetation]") {
    const double steepness = GENERATE(1.0, 2.0, 3.0);
    MadeLand land([&](int x, int z, Returns& out) {
        const double d = std::hypot(x - 30, z - 30);
        put(out, d > 4 ? std::numeric_limits<double>::quiet_NaN() : 30.5 - steepness * d);
    });
    const auto crowns = find_crowns(land);
    int pairs = 0;
    for (int z = 26; z <= 34; ++z)
        for (int x = 26; x <= 34; ++x)
            for (const auto& [dx, dz] : {std::pair{1, 0}, {0, 1}}) {
                const Crown &a = crowns.at(x, z), &b = crowns.at(x + dx, z + dz);
                if (!a.seen() || !b.seen())
                    continue;
                ++pairs;
                INFO("columns " << x << ", " << z << " and " << x + dx << ", " << z + dz << ": ["
                                << a.bottom << ", " << a.top << "] and [" << b.bottom << ", "
                                << b.top << "]");
                CHECK(a.bottom <= a.top);
                CHECK((a.bottom <= b.top && b.bottom <= a.top));
            }
    CHECK(pairs > 50);
}

TEST_CASE("a much lower plant next to a tree does not pull its crown down to the ground",
          "[voxelserver][voxelize][vegetation]") {
    MadeLand land([](int x, int z, Returns& out) {
        put(out, std::hypot(x - 30, z - 30) <= 3   ? 40.5
                 : std::hypot(x - 37, z - 30) <= 4 ? 15.5
                                                   : std::nan(""));
    });
    const auto crowns = find_crowns(land);
    REQUIRE(crowns.at(33, 30).top == 40);
    CHECK(crowns.at(33, 30).bottom > 20);
}

TEST_CASE("each tree has one trunk, under its top, wherever patches meet",
          "[voxelserver][voxelize][vegetation]") {
    const auto [mid_x, mid_z] = GENERATE(table<int, int>({{30, 30}, {0, 0}, {63, 64}, {2, 62}}));
    struct Case {
        const char* name;
        double top;
        double radius;
    };
    const auto c = GENERATE(values<Case>({{"small", 16.75, 2}, {"tall", 35.75, 6}}));
    DYNAMIC_SECTION(c.name << ", at " << mid_x << " " << mid_z) {
        MadeLand land([&, mx = mid_x, mz = mid_z](int x, int z, Returns& out) {
            put(out, cone(x, z, mx, mz, c.top, c.radius));
        });
        const auto trunks = find_trunks(land);
        REQUIRE(trunks.size() == 1);
        CHECK(trunks.front() == std::pair(mid_x, mid_z));
    }
}

TEST_CASE("a flat crown wider than the window has one trunk, inside, wherever patches meet",
          "[voxelserver][voxelize][vegetation]") {
    struct Case {
        const char* name;
        double half_wide;
        double half_deep;
        double turn_rad;
        bool round;
        double offset;
    };
    const auto c = GENERATE(values<Case>({
        {"disc of radius 3.4", 3.4, 3.4, 0, true, 1.75},
        {"disc of radius 12", 12, 12, 0, true, 10.5},
        {"oval", 6, 3, 0.4, true, 3.5},
        {"narrow oval", 6, 2, 0.2, true, 5.5},
        {"square", 5, 5, 0, false, 4.5},
        {"hedge along x", 15, 1, 0, false, 15.5},
        {"hedge across", 15, 1.5, 0.785, false, 15.5},
    }));
    const auto [mid_x, mid_z] = GENERATE(table<double, double>({{0.3, 0.6}, {63.5, 64}}));
    DYNAMIC_SECTION(c.name << ", at " << mid_x << " " << mid_z) {
        const auto on_top = [&, mx = mid_x, mz = mid_z](double x, double z) {
            const double along =
                ((x - mx) * std::cos(c.turn_rad) + (z - mz) * std::sin(c.turn_rad)) / c.half_wide;
            const double across =
                ((z - mz) * std::cos(c.turn_rad) - (x - mx) * std::sin(c.turn_rad)) / c.half_deep;
            return c.round ? std::hypot(along, across) <= 1
                           : std::max(std::abs(along), std::abs(across)) <= 1;
        };
        const bool skirt = GENERATE(true, false);  // lower foliage around, or cut off as a hedge is
        INFO((skirt ? "with" : "without") << " a skirt");
        MadeLand land([&, mx = mid_x, mz = mid_z](int x, int z, Returns& out) {
            put(out, on_top(x, z) ? 25.5
                     : skirt      ? 15 + cone(x, z, mx, mz, 36, 18) / 4
                                  : std::nan(""));
        });
        const auto trunks = find_trunks(land);
        INFO("trunks at" << to_text(trunks));
        REQUIRE(trunks.size() == 1);
        CHECK(on_top(trunks.front().first, trunks.front().second));
        CHECK(std::hypot(trunks.front().first - mid_x, trunks.front().second - mid_z) <= c.offset);
    }
}

namespace {

/// Trees of which few pulses return: four columns of five have a return of the crown, one of them
/// from deep inside and one more two, and one has one of the ground.
MadeLand sparse_wood(std::uint8_t code) {
    return MadeLand([code](int x, int z, Returns& out) {
        const int dx = ((x % 12) + 12) % 12 - 6;
        const int dz = ((z % 12) + 12) % 12 - 6;
        const double off = std::hypot(dx, dz);
        const double chance = dice(x, z, 21);
        const double top = 32.5 - 0.15 * off * off;
        if (off <= 6 && chance > 0.2 && chance < 0.8)
            out.push_back({top, code});
        if (off <= 6 && chance < 0.4)
            out.push_back({top - 4 - 5 * dice(x, z, 22), code});
        if (off > 6 || chance > 0.9)
            out.push_back({kGround, kGroundClass});
    });
}

}  // namespace

TEST_CASE("unclassified trees of few returns have crowns that join, and a trunk or two each",
          "[voxelserver][voxelize][vegetation]") {
    MadeLand land = sparse_wood(kUnsorted);
    const auto crowns = find_crowns(land);
    int columns = 0;
    int under = 0;
    int filled = 0;
    for (int z = 2; z < 62; ++z)
        for (int x = 2; x < 62; ++x)
            if (std::hypot(x % 12 - 6, z % 12 - 6) <= 3) {
                ++columns;
                const Crown& crown = crowns.at(x, z);
                under += crown.seen() ? 1 : 0;
                filled += crown.seen() && crown.bottom <= kGround + 12 ? 1 : 0;
            }
    INFO(columns << " columns");
    CHECK(under > 0.95 * columns);
    CHECK(filled > 0.9 * columns);
    MadeLand classified = sparse_wood(kTree);
    const auto few = find_trunks(land).size();
    CHECK(few <= 2 * 16 * 16);  // of 16 by 16 trees in nine patches
    CHECK(2 * few < find_trunks(classified).size());
}

TEST_CASE("a hole among eight unclassified crowns takes the middle one's height",
          "[voxelserver][voxelize][vegetation]") {
    struct Case {
        const char* name;
        double own;  ///< 0: nothing but the ground
        std::int32_t top;
    };
    const auto c = GENERATE(values<Case>({
        {"a low return", 15.5, 27},
        {"the ground", 0, 27},
        {"a return as high", 25.5, 25},
    }));
    DYNAMIC_SECTION(c.name) {
        MadeLand land([&](int x, int z, Returns& out) {
            const bool is_middle = x == 30 && z == 30;
            if (std::abs(x - 30) > 1 || std::abs(z - 30) > 1 || c.own == 0)
                out.push_back({kGround, kGroundClass});
            if (is_middle && c.own != 0)
                out.push_back({c.own, kUnsorted});
            if (!is_middle && std::abs(x - 30) <= 1 && std::abs(z - 30) <= 1)
                out.push_back({22.5 + (x - 29) + 3 * (z - 29), kUnsorted});
        });
        CHECK(find_crowns(land).at(30, 30).top == c.top);
    }
}

TEST_CASE("a level unclassified thing that no pulse passes is no tree",
          "[voxelserver][voxelize][vegetation]") {
    const bool leaky = GENERATE(false, true);
    CAPTURE(leaky);
    MadeLand land([&](int x, int z, Returns& out) {
        const bool deck = z >= 30 && z < 35;
        if (deck)
            out.push_back({20.5 + (z == 30 || z == 34 ? 1 : 0) + 0.4 * dice(x, z, 5), kUnsorted});
        if (!deck || (leaky && dice(x, z, 6) < 0.5))
            out.push_back({kGround, kGroundClass});
    });
    CHECK(find_trunks(land).empty() == !leaky);
    CHECK((find_crowns(land).at(20, 32).bottom < 17) == leaky);
}

TEST_CASE("unclassified masts and wires are no trees", "[voxelserver][voxelize][vegetation]") {
    struct Case {
        const char* name;
        bool (*holds)(int x, int z);
        bool tree;
    };
    const auto c = GENERATE(values<Case>({
        {"a mast", [](int x, int z) { return x == 30 && (z == 30 || z == 31); }, false},
        {"a wire", [](int, int z) { return z == 30; }, false},
        {"a poplar", [](int x, int z) { return std::hypot(x - 30, z - 30) <= 2; }, true},
    }));
    const double voxel_m = GENERATE(1.0, 0.5);  // a window of 5 columns shows a part of the tree
    DYNAMIC_SECTION(c.name << ", voxels of " << voxel_m << " m") {
        const auto at = [&](int v) {
            return static_cast<int>(std::floor((v - 30) * voxel_m)) + 30;
        };
        MadeLand land([&](int x, int z, Returns& out) {
            out.push_back({kGround, kGroundClass});
            if (c.holds(at(x), at(z)))
                out.push_back({kGround + 20 / voxel_m, kUnsorted});
        });
        CHECK(find_trunks(land, voxel_m).empty() == !c.tree);
        const Crown crown = find_crowns(land, {0, 0}, voxel_m).at(30, 30);
        CHECK(crown.top == std::floor(kGround + 20 / voxel_m));
        CHECK((crown.bottom < crown.top) == c.tree);
    }
}

TEST_CASE("no foliage is guessed before a wall", "[voxelserver][voxelize][vegetation]") {
    MadeLand land([](int x, int z, Returns& out) {
        if (x < 30)
            out.push_back({35.5, kBuilding});
        else
            put(out, cone(x, z, 33, 30, 30.5, 5));
    });
    const auto crowns = find_crowns(land);
    REQUIRE(crowns.at(30, 30).seen());
    CHECK(crowns.at(30, 30).bottom == crowns.at(30, 30).top);
    CHECK(crowns.at(32, 30).bottom < crowns.at(32, 30).top);
}

TEST_CASE("a flat crown next to a higher top leaves the trunk to it",
          "[voxelserver][voxelize][vegetation]") {
    MadeLand land([](int x, int z, Returns& out) {
        put(out, std::max(std::abs(x - 30), std::abs(z - 30)) <= 1 ? 26.5
                 : std::hypot(x - 30, z - 30) <= 3                 ? 25.5
                                                                   : std::nan(""));
    });
    CHECK(to_text(find_trunks(land)) == " (30, 30)");
}

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
