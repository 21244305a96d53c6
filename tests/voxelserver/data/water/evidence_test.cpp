#include "voxelserver/data/water/evidence.hpp"

#include <cmath>

#include "tests/catch.hpp"
#include "tests/voxelserver/data/water/landscapes.hpp"
#include "voxelserver/data/water/body_finder.hpp"

using namespace terravox::water;
using namespace terravox::water::test;

namespace {

constexpr int kSide = 32;

bool within(std::int32_t x, std::int32_t z, std::int32_t x0, std::int32_t z0, std::int32_t w,
            std::int32_t h) {
    return x >= x0 && z >= z0 && x < x0 + w && z < z0 + h;
}

// The level at cell (20, 20); cells are 2 m.
float find_level(const FunctionSource::Make& make, const Evidence& evidence = {}) {
    FunctionSource source(kSide, make);
    WaterOptions options;
    options.evidence = evidence;
    return WaterBodies(source, options).level(20, 20);
}

bool covered(std::int32_t x, std::int32_t z) {
    return within(x, z, -200, -200, 400, 400);
}

struct Rect {
    std::int32_t x0, z0, wide, deep;
};
// The hole that most cases have: 320 m2 around the queried cell.
constexpr Rect kHole{15, 16, 10, 8};

WaterCell ripple(std::int32_t x, std::int32_t z, float height) {
    return ground_at(height + 0.05f * static_cast<float>((x * 7 + z * 13) % 5));
}

}  // namespace

TEST_CASE("a void is water within a level shore, and what looks wet where it is flat and wide",
          "[water][evidence]") {
    using Cell = WaterCell (*)(std::int32_t x, std::int32_t z);
    const Cell unseen = [](auto, auto) { return nothing_seen(); };
    const Cell low = [](auto x, auto z) { return ripple(x, z, 40); };
    const Cell wet_low = [](auto x, auto z) { return wet(ripple(x, z, 40)); };
    const Cell high = [](auto x, auto z) { return ripple(x, z, 41); };
    const Cell slope = [](auto x, auto z) {
        return ripple(x, z, 40.0f + 0.1f * static_cast<float>(x));
    };
    const Cell wet_slope = [](auto x, auto z) {
        return wet(ripple(x, z, 40.0f + 0.1f * static_cast<float>(x)));
    };
    const Cell banks = [](auto x, auto z) {
        return ripple(x, z, 40.0f + 0.4f * static_cast<float>((x * 5 + z * 3) % 5 / 2));
    };
    const Cell roofs = [](auto x, auto z) {
        return within(x, z, 14, 15, 12, 10) ? thing() : ripple(x, z, 40);
    };
    const Cell trees = [](auto x, auto z) {
        WaterCell cell = ripple(x, z, 40);
        cell.other_points = 60;
        return cell;
    };
    const Cell wet_trees = [](auto, auto) { return wet(thing()); };
    const Cell wet_void = [](auto, auto) { return wet(nothing_seen()); };
    const Cell beyond = [](auto, auto) { return wet(WaterCell{}); };
    const auto by_void = &Evidence::by_void;
    const auto by_photo = &Evidence::by_photo;
    struct Case {
        const char* name;
        bool Evidence::* by;
        Cell inside;
        Cell around;
        bool water;
        Rect where = kHole;
        std::int32_t west = -200;  // of the survey
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"a pond of 10 x 8 cells", by_void, unseen, low, true},
        {"banks on one half of the shore", by_void, unseen, banks, true},
        {"too small", by_void, unseen, low, false, {18, 18, 6, 6}},
        {"a hillside of 5 %", by_void, unseen, slope, false},
        {"at the survey's edge", by_void, unseen, low, false, kHole, 15},
        {"a black roof among roofs", by_void, unseen, roofs, false},
        {"the thin shadow of a tower", by_void, unseen, low, false, {0, 20, 60, 2}},
        {"among trees through which the ground is seen", by_void, unseen, trees, true},
        {"a pond that was classified as ground", by_photo, wet_low, high, true},
        {"a meadow on a slope of 5 %", by_photo, wet_slope, slope, false},
        {"a puddle", by_photo, wet_low, high, false, {18, 18, 5, 5}},
        {"dark trees", by_photo, wet_trees, high, false},
        {"outside the survey", by_photo, beyond, beyond, false},
        {"wet voids in flat ground, at the edge", by_photo, wet_void, high, false, kHole, 15},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto make = [&](std::int32_t x, std::int32_t z) {
            if (!covered(x, z) || x < c.west)
                return WaterCell{};
            const Rect& r = c.where;
            return within(x, z, r.x0, r.z0, r.wide, r.deep) ? c.inside(x, z) : c.around(x, z);
        };
        const float level = find_level(make);
        if (c.water)
            CHECK((level >= 39.99f && level <= 40.2f));
        else
            CHECK(std::isnan(level));
        Evidence without;
        without.*c.by = false;
        CHECK(std::isnan(find_level(make, without)));
    }
}

TEST_CASE("water by class needs three returns and takes the voids around them",
          "[water][evidence]") {
    const auto returns = GENERATE(2, 3);
    const auto make = [&](std::int32_t x, std::int32_t z) {
        if (!covered(x, z))
            return WaterCell{};
        if (!within(x, z, 17, 17, 6, 6))
            return ripple(x, z, 41);
        return x == 17 && z == 17 ? water_at(40.25f, static_cast<std::uint16_t>(returns))
                                  : nothing_seen();
    };
    if (returns == 3)
        CHECK(find_level(make) == 40.25f);
    else
        CHECK(std::isnan(find_level(make)));
    Evidence without;
    without.by_class = false;
    CHECK(std::isnan(find_level(make, without)));
}

TEST_CASE("a cell is open when water returns outnumber others by more than two to one",
          "[water][evidence]") {
    WaterCell c = water_at(3, 5);
    c.ground_points = 1;
    c.other_points = 1;
    CHECK(is_open(c));
    c.water_points = 4;
    CHECK_FALSE(is_open(c));
    c = water_at(kNoLevel, 500);
    c.ground_points = 1;
    CHECK_FALSE(is_open(c));  // counted, but no height
    c = nothing_seen();
    CHECK(is_open(c));
    c.covered = false;
    CHECK_FALSE(is_open(c));
}

TEST_CASE("class, photo and voids meet in one body, and a wet slope next to it stays dry",
          "[water][evidence]") {
    // From west to east: returns of class water, a void (glint), wet cells taken for ground; south
    // of it a wet-looking slope.
    const auto make = [](std::int32_t x, std::int32_t z) {
        if (!covered(x, z))
            return WaterCell{};
        if (within(x, z, 0, 10, 12, 20))
            return (x + z) % 3 == 0 ? water_at(40, 4) : nothing_seen();
        if (within(x, z, 12, 10, 3, 20))
            return nothing_seen();
        if (within(x, z, 15, 10, 25, 20))
            return x > 30 && x < 33 && z > 15 && z < 20 ? nothing_seen() : wet(ground_at(40.02f));
        if (within(x, z, 70, 0, 30, 60))
            return wet(ground_at(41.0f + 0.3f * static_cast<float>(z)));
        if (within(x, z, 40, 20, 30, 2))
            return wet(ground_at(40.02f));  // joins the two
        return ripple(x, z, 41);
    };
    FunctionSource source(kSide, make);
    WaterBodies bodies(source, {});
    const float level = bodies.level(2, 12);
    CHECK(level == Approx(40.02).margin(0.03));
    CHECK(bodies.level(13, 12) == level);
    // The wet part touches a slope: it is not flat, so only class and voids remain.
    CHECK(std::isnan(bodies.level(31, 17)));
    CHECK(std::isnan(bodies.level(80, 50)));
    FunctionSource apart(kSide, [&](std::int32_t x, std::int32_t z) {
        return within(x, z, 40, 20, 30, 2) ? ripple(x, z, 41) : make(x, z);
    });
    WaterBodies parted(apart, {});
    const float one = parted.level(2, 12);
    for (const auto& [x, z] : {std::pair{13, 12}, {20, 20}, {31, 17}, {39, 29}})
        CHECK(parted.level(x, z) == one);
    CHECK(std::isnan(parted.level(80, 50)));
}
