// Roofs: whose column it is, gaps, and what is open beneath.
// Which roofs are one building, and that all patches agree about it.
#include <cmath>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"
#include "voxelserver/make/voxelize/steps/buildings.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

using Returns = MadeLand::Returns;

/// A rectangle of columns, half-open.
struct Place {
    int x0;
    int z0;
    int x1;
    int z1;
    [[nodiscard]] bool holds(int x, int z) const noexcept {
        return x >= x0 && x < x1 && z >= z0 && z < z1;
    }
    [[nodiscard]] bool edge(int x, int z) const noexcept {
        return holds(x, z) && (x == x0 || z == z0 || x == x1 - 1 || z == z1 - 1);
    }
};

Margined<Roof> find_roofs(const MadeLand::ReturnsAt& returns, double voxel_m = 1,
                          const Settings::Buildings& settings = {}) {
    return fill_buildings(MadeLand(returns).window({0, 0}), settings, voxel_m);
}

void put(Returns& out, int roofs, double roof, int grounds, double ground = 10.5) {
    for (int i = 0; i < roofs; ++i)
        out.push_back({roof + 0.001 * i, kBuilding});
    for (int i = 0; i < grounds; ++i)
        out.push_back({ground, kGroundClass});
}

constexpr Place kHouse{20, 20, 32, 30};

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

TEST_CASE("gaps between points of a roof are closed, except where pulses reached the ground",
          "[voxelserver][voxelize][buildings]") {
    struct Case {
        const char* name;
        Place gap;
        bool ground_seen;
        bool closed;
    };
    const auto c = GENERATE(values<Case>({
        {"one column without returns", {25, 25, 26, 26}, false, true},
        {"a row without returns", {22, 25, 30, 26}, false, true},
        {"one pulse through a skylight", {25, 25, 26, 26}, true, true},
        {"a courtyard of 2 x 2", {25, 25, 27, 27}, true, false},
        {"a courtyard of 4 x 3", {24, 24, 28, 27}, true, false},
        {"the middle of a wide hole", {23, 23, 29, 28}, false, false},
        {"next to the house", {32, 25, 33, 26}, false, false},
        {"a corner", {20, 20, 21, 21}, false, false},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto roofs = find_roofs([&](int x, int z, Returns& out) {
            if (c.gap.holds(x, z))
                put(out, 0, 0, c.ground_seen ? 2 : 0);
            else
                put(out, kHouse.holds(x, z) ? 3 : 0, 20.5 + 0.25 * (x - 20),
                    kHouse.holds(x, z) ? 0 : 3);
        });
        const int x = (c.gap.x0 + c.gap.x1) / 2;
        const int z = (c.gap.z0 + c.gap.z1) / 2;
        CHECK(roofs.at(x, z).seen() == c.closed);
        if (c.closed)
            CHECK(std::abs(roofs.at(x, z).top.height -
                           (20.5f + 0.25f * static_cast<float>(x - 20))) <=
                  0.26f);  // the median of those around
        CHECK_FALSE(roofs.at(33, 25).seen());
        if (c.closed)
            CHECK_FALSE(roofs.at(x, z).open_beneath());
    }
}

TEST_CASE("a closed gap looks like the neighbour whose height it took",
          "[voxelserver][voxelize][buildings]") {
    const auto roofs = find_roofs([&](int x, int z, Returns& out) {
        if (x == 25 && z == 25)
            return;
        if (kHouse.holds(x, z))
            out.push_back({20 + 0.125 * x + 0.25 * z, kBuilding});
        else
            out.push_back({10, kGroundClass});
    });
    const Roof& r = roofs.at(25, 25);
    REQUIRE(r.seen());
    REQUIRE((r.appearance_dx != 0 || r.appearance_dz != 0));
    CHECK(r.top.height == roofs.at(25 + r.appearance_dx, 25 + r.appearance_dz).top.height);
    CHECK((roofs.at(26, 26).appearance_dx == 0 && roofs.at(26, 26).appearance_dz == 0));
}

TEST_CASE("canopies, carports, balconies and passages are open beneath; houses are not",
          "[voxelserver][voxelize][buildings]") {
    // Every column of the place has returns of a roof and of the ground beneath it.
    struct Case {
        const char* name;
        double voxel_m;
        double storey_m;
        Place place;
        double above_m;
        double bottom_m;
    };
    constexpr double kClosed = 0;
    const auto c = GENERATE(values<Case>({
        {"a canopy", 1, 3, {20, 20, 28, 26}, 5, 5},
        {"a carport two columns wide", 1, 3, {20, 20, 26, 22}, 4, 4},
        {"too low to walk under", 1, 3, {20, 20, 28, 26}, 2.5, kClosed},
        {"low, with a lower storey configured", 1, 2, {20, 20, 28, 26}, 2.5, 2.5},
        {"half metres, high enough", 0.5, 3, {20, 20, 36, 32}, 4, 4},
        {"half metres, too low", 0.5, 3, {20, 20, 36, 32}, 2.5, kClosed},
        {"a house over a passage", 1, 3, {20, 20, 28, 26}, 15, 3},
    }));
    DYNAMIC_SECTION(c.name) {
        Settings::Buildings settings;
        settings.storey_m = c.storey_m;
        const double ground = 10.5;
        const auto roofs = find_roofs(
            [&](int x, int z, Returns& out) {
                put(out, c.place.holds(x, z) ? 3 : 0, ground + c.above_m / c.voxel_m,
                    c.place.holds(x, z) ? 2 : 3, ground);
            },
            c.voxel_m, settings);
        Margined<Roof>::each([&](int x, int z) {
            INFO("column " << x << ", " << z);
            REQUIRE(roofs.at(x, z).seen() == c.place.holds(x, z));
            if (!c.place.holds(x, z))
                return;
            REQUIRE(roofs.at(x, z).open_beneath() == (c.bottom_m != kClosed));
            if (c.bottom_m != kClosed)
                REQUIRE(roofs.at(x, z).bottom == Approx(ground + c.bottom_m / c.voxel_m));
        });
    }
}

TEST_CASE("a balcony is open between what was seen beneath it and the wall that it hangs on",
          "[voxelserver][voxelize][buildings]") {
    // The house is 10 m high; the balcony, three columns deep, 4 m above the ground; pulses got
    // under its outermost column only.
    const Place house{20, 10, 40, 30};
    const Place balcony{26, 30, 34, 33};
    const auto roofs = find_roofs([&](int x, int z, Returns& out) {
        if (house.holds(x, z))
            put(out, 3, 20.5, 0);
        else if (balcony.holds(x, z))
            put(out, 3, 14.5, z == 32 ? 2 : 0);
        else
            put(out, 0, 0, 3);
    });
    Margined<Roof>::each([&](int x, int z) {
        INFO("column " << x << ", " << z);
        REQUIRE(roofs.at(x, z).open_beneath() == balcony.holds(x, z));
    });
}

TEST_CASE(
    "a column beneath a canopy that no pulse reached is as open as those around, unless a wall was "
    "seen in it",
    "[voxelserver][voxelize][buildings]") {
    const bool wall = GENERATE(false, true);
    INFO((wall ? "with a wall" : "without returns from below"));
    const auto roofs = find_roofs([&](int x, int z, Returns& out) {
        if (!Place{20, 20, 30, 30}.holds(x, z))
            return put(out, 0, 0, 3);
        put(out, 3, 18.5, x == 25 && z == 25 ? 0 : 2);
        if (wall && x == 25 && z == 25)
            out.push_back({11.5, kBuilding});
    });
    REQUIRE(roofs.at(24, 24).open_beneath());
    CHECK(roofs.at(25, 25).open_beneath() == !wall);
}

TEST_CASE("with the step switched off roofs are what was seen",
          "[voxelserver][voxelize][buildings]") {
    MadeLand land([](int x, int z, Returns& out) { put(out, (x + z) % 3 == 0 ? 1 : 0, 20, 2); });
    const auto roofs = seen_roofs(land.window({0, 0}));
    Margined<Roof>::each([&](int x, int z) {
        REQUIRE(roofs.at(x, z).seen() == ((x + z) % 3 == 0));
        REQUIRE_FALSE(roofs.at(x, z).open_beneath());
    });
}

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
