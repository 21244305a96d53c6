// Crowns and trunks.
#include <cmath>

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

struct Plateau {
    int trunks = 0;
    int wide = 0;
    int deep = 0;
    bool hidden = false;  ///< a higher crown touches it
};

/// Flooded without any limit. @param met marks its columns
Plateau plateau_at(const Margined<Crown>& crowns, int x, int z, Grid<char, 2>& met) {
    Plateau out;
    std::vector<std::pair<int, int>> columns{{x, z}};
    int min_x = x, max_x = x, max_z = z;  // met first: none lies farther north
    for (std::size_t i = 0; i < columns.size(); ++i) {
        const auto [own_x, own_z] = columns[i];
        const Crown& own = crowns.at(own_x, own_z);
        out.trunks += own.trunk ? 1 : 0;
        min_x = std::min(min_x, own_x);
        max_x = std::max(max_x, own_x);
        max_z = std::max(max_z, own_z);
        for (int dz = -1; dz <= 1; ++dz)
            for (int dx = -1; dx <= 1; ++dx) {
                const Crown& next = crowns.at(own_x + dx, own_z + dz);
                out.hidden = out.hidden || (next.seen() && next.height > own.height);
                if (next.seen() && next.height == own.height &&
                    met.at(own_x + dx, own_z + dz)++ == 0)
                    columns.emplace_back(own_x + dx, own_z + dz);
            }
    }
    out.wide = max_x - min_x + 1;
    out.deep = max_z - z + 1;
    return out;
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

TEST_CASE("a flat crown next to a higher top leaves the trunk to it",
          "[voxelserver][voxelize][vegetation]") {
    MadeLand land([](int x, int z, Returns& out) {
        put(out, std::max(std::abs(x - 30), std::abs(z - 30)) <= 1 ? 26.5
                 : std::hypot(x - 30, z - 30) <= 3                 ? 25.5
                                                                   : std::nan(""));
    });
    CHECK(to_text(find_trunks(land)) == " (30, 30)");
}

TEST_CASE(
    "in a wood of plateaus of any shape each highest one keeps a trunk, and a small one has no "
    "second",
    "[voxelserver][voxelize][vegetation]") {
    const auto seed = static_cast<std::uint32_t>(GENERATE(range(1, 6)));
    MadeLand land([&](int x, int z, Returns& out) {
        const bool wood = x >= 4 && x < 60 && z >= 4 && z < 60;
        if (wood)
            out.push_back({20.5 + std::floor(3 * dice(x >> 1, z >> 1, seed)), kTree});
        else
            out.push_back({kGround, kGroundClass});
    });
    const auto crowns = find_crowns(land);
    Grid<char, 2> met(0);
    int highest = 0;
    Margined<Crown>::each([&](int first_x, int first_z) {
        if (!crowns.at(first_x, first_z).seen() || met.at(first_x, first_z)++ != 0)
            return;
        const Plateau plateau = plateau_at(crowns, first_x, first_z, met);
        INFO("seed " << seed << ", plateau with " << first_x << " " << first_z << ", "
                     << plateau.wide << " x " << plateau.deep);
        constexpr int kSight = 5;
        if (std::max(plateau.wide, plateau.deep) <= kSight + 1)
            REQUIRE(plateau.trunks <= 1);
        if (plateau.hidden)
            return;
        ++highest;
        REQUIRE(plateau.trunks >= 1);
    });
    CHECK(highest > 10);
}
