// Column init: what the points of one column give, before any neighbour is considered.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

/// The columns of a patch whose column (5, 7) has these returns.
std::shared_ptr<PatchColumns> with_one(const std::vector<Return>& returns,
                                       bool has_colour = false) {
    std::vector<store::VoxelPoint> points;
    for (const Return& r : returns)
        points.push_back(point_at(5, 7, r));
    std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.y < b.y; });
    const PatchPoints source{points, has_colour};
    return init_columns({&source, 1}, asprs(), 4);
}

bool same(const Surface& a, const Surface& b) {
    return std::memcmp(&a.height, &b.height, sizeof a.height) == 0 &&
           a.source_class == b.source_class && a.has_colour == b.has_colour && a.colour == b.colour;
}
bool same(float a, float b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}
bool same(const Column& a, const Column& b) {
    return same(a.ground, b.ground) && same(a.roof, b.roof) && same(a.water, b.water) &&
           same(a.deck, b.deck) && same(a.roof_low, b.roof_low) &&
           a.ground_points == b.ground_points && a.roof_points == b.roof_points &&
           a.water_points == b.water_points && a.deck_points == b.deck_points &&
           a.roof_over_ground == b.roof_over_ground;
}
bool same_object(const ObjectVoxel& a, const ObjectVoxel& b) {
    return a.y == b.y && a.source_class == b.source_class && a.has_colour == b.has_colour &&
           a.colour == b.colour && a.fraction == b.fraction;
}
bool same_cell(const water::WaterCell& a, const water::WaterCell& b) {
    return same(a.water, b.water) && same(a.ground, b.ground) && a.water_points == b.water_points &&
           a.ground_points == b.ground_points && a.other_points == b.other_points;
}
bool same(const PatchColumns& a, const PatchColumns& b) {
    const auto column = [](const Column& p, const Column& q) { return same(p, q); };
    const auto height = [](float p, float q) { return same(p, q); };
    const auto &cells = a.cells.cells, &others = b.cells.cells;
    return std::equal(a.columns.begin(), a.columns.end(), b.columns.begin(), column) &&
           std::equal(a.objects.begin(), a.objects.end(), b.objects.begin(), b.objects.end(),
                      same_object) &&
           a.objects_begin == b.objects_begin && a.occupied == b.occupied && a.built == b.built &&
           std::equal(a.ground_height.begin(), a.ground_height.end(), b.ground_height.begin(),
                      height) &&
           a.any_roof == b.any_roof && a.any_deck == b.any_deck && a.any_objects == b.any_objects &&
           a.any == b.any && same(a.lowest, b.lowest) &&
           std::equal(cells.begin(), cells.end(), others.begin(), others.end(), same_cell);
}

}  // namespace

TEST_CASE("ground, water and decks are medians, roofs the highest",
          "[voxelserver][voxelize][columns]") {
    constexpr float kNone = -1;
    struct Case {
        const char* name;
        std::vector<Return> returns;
        float ground = kNone;
        float roof = kNone;
        float roof_low = kNone;
        float water = kNone;
        float deck = kNone;
    };
    const auto c = GENERATE(values<Case>({
        {.name = "nothing", .returns = {}},
        {.name = "one of the ground", .returns = {{10.25, kGroundClass}}, .ground = 10.25},
        {.name = "a low and a high outlier",
         .returns = {{10.25, kGroundClass},
                     {10.5, kGroundClass},
                     {3, kGroundClass},
                     {99, kGroundClass},
                     {10.375, kGroundClass}},
         .ground = 10.375},
        {.name = "rail and road are ground as well",
         .returns = {{10, 10}, {11, 11}, {12, 20}},
         .ground = 11},
        {.name = "a roof over the ground",
         .returns = {{10, kGroundClass}, {18.5, kBuilding}, {17.25, kBuilding}, {18, kBuilding}},
         .ground = 10,
         .roof = 18.5,
         .roof_low = 17.25},
        {.name = "a deck over water",
         .returns = {{5, kWater}, {15.5, kBridge}, {15.25, kBridge}, {18, kBridge}},
         .water = 5,
         .deck = 15.5},
        {.name = "plants and wires are none of them",
         .returns = {{5, kTree}, {6, kWire}, {7, kUnsorted}, {8, 200}}},
        {.name = "below zero",
         .returns = {{-10.25, kGroundClass}, {-3.5, kBuilding}},
         .ground = -10.25,
         .roof = -3.5,
         .roof_low = -3.5},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto patch = with_one(c.returns);
        const Column& column = patch->at(5, 7);
        const auto check = [](float found, float wanted) {
            CHECK((wanted == kNone ? std::isnan(found) : found == wanted));
        };
        check(column.ground.height, c.ground);
        check(column.roof.height, c.roof);
        check(column.roof_low, c.roof_low);
        check(column.water.height, c.water);
        check(column.deck.height, c.deck);
        check(patch->ground_height[7 * 64 + 5], c.ground);
        CHECK(patch->any == !c.returns.empty());
        CHECK(patch->any_roof == (c.roof != kNone));
        CHECK(patch->any_deck == (c.deck != kNone));
        CHECK(patch->occupied[7] == (c.returns.empty() ? 0 : std::uint64_t{1} << 5));
        CHECK(std::count(patch->occupied.begin(), patch->occupied.end(), 0u) >= 63);
        for (const int other : {0, 1, 7 * 64 + 4, 7 * 64 + 6, 4095})
            CHECK_FALSE(patch->columns[static_cast<std::size_t>(other)].ground.seen());
        if (!c.returns.empty())
            CHECK(patch->lowest ==
                  static_cast<float>(
                      std::min_element(c.returns.begin(), c.returns.end(), [](auto& a, auto& b) {
                          return a.height < b.height;
                      })->height));
    }
}

TEST_CASE("a column is built upon when most of its low returns are of a building",
          "[voxelserver][voxelize][columns]") {
    struct Case {
        const char* name;
        int roof;
        int ground;
        int water;
        int plants;
        bool built;
    };
    const auto c = GENERATE(values<Case>({
        {"nothing", 0, 0, 0, 0, false},
        {"only a roof", 1, 0, 0, 0, true},
        {"only ground", 0, 3, 0, 0, false},
        {"half and half", 2, 2, 0, 0, true},
        {"more ground", 2, 3, 0, 0, false},
        {"ground and water together", 3, 2, 2, 0, false},
        {"more roof", 3, 2, 0, 0, true},
        {"plants do not count", 1, 0, 0, 50, true},
    }));
    DYNAMIC_SECTION(c.name) {
        std::vector<Return> returns;
        for (const auto& [count, code] : {std::pair{c.roof, kBuilding},
                                          {c.ground, kGroundClass},
                                          {c.water, kWater},
                                          {c.plants, kTree}})
            for (int i = 0; i < count; ++i)
                returns.push_back({10.0 + i, code});
        const auto patch = with_one(returns);
        const Column& column = patch->at(5, 7);
        CHECK((column.roof_points == c.roof && column.ground_points == c.ground &&
               column.water_points == c.water && column.deck_points == 0));
        CHECK(column.built_upon() == c.built);
        CHECK(patch->built[7] == (c.built ? std::uint64_t{1} << 5 : 0));
    }
}

TEST_CASE("ground next to a roof in one column is not beneath it",
          "[voxelserver][voxelize][columns]") {
    struct Case {
        const char* name;
        double roof_m;
        double parted_at;
        double angle_deg;
        bool over;
    };
    constexpr double kMixed = -1;
    const auto c = GENERATE(values<Case>({
        {"an edge from north to south", 8, 0.5, 0, false},
        {"an edge from west to east", 8, 0.4, 90, false},
        {"a slanting edge", 8, 0.5, 30, false},
        {"a sliver of roof", 8, 0.85, 30, false},
        {"a sliver of ground", 8, 0.15, -60, false},
        {"a canopy", 8, kMixed, 0, true},
        {"a step of less than a voxel", 0.9, kMixed, 0, false},
    }));
    DYNAMIC_SECTION(c.name) {
        std::vector<Return> returns;
        std::mt19937 random(4);
        const double s = std::sin(c.angle_deg * 0.0174533);
        const double k = std::cos(c.angle_deg * 0.0174533);
        for (int i = 0; i < 40; ++i) {
            const double e = static_cast<double>(random() % 1000) / 1000;
            const double n = static_cast<double>(random() % 1000) / 1000;
            const bool roof = c.parted_at == kMixed
                                  ? i % 2 == 0
                                  : (e - 0.5) * k + (n - 0.5) * s > c.parted_at - 0.5;
            returns.push_back(
                {roof ? 10 + c.roof_m : 10.0, roof ? kBuilding : kGroundClass, {}, e, n});
        }
        CHECK(with_one(returns)->at(5, 7).roof_over_ground == c.over);
    }
}

TEST_CASE("counts saturate instead of starting again", "[voxelserver][voxelize][columns]") {
    std::vector<Return> returns(70'000, Return{10, kGroundClass});
    returns.insert(returns.end(), 66'000, Return{20, kBuilding});
    const auto patch = with_one(returns);
    CHECK((patch->at(5, 7).ground_points == 65'535 && patch->at(5, 7).roof_points == 65'535));
    CHECK((patch->cells.at(1, 1).ground_points == 65'535 &&
           patch->cells.at(1, 1).other_points == 65'535));
}

TEST_CASE("the class that most returns have names a surface; of equals the lower code",
          "[voxelserver][voxelize][columns]") {
    struct Case {
        const char* name;
        std::vector<std::uint8_t> classes;
        std::uint8_t wanted;
    };
    const auto c = GENERATE(values<Case>({
        {"one", {11}, 11},
        {"most", {2, 11, 11}, 11},
        {"a tie", {11, 2}, 2},
        {"a tie the other way round", {2, 11}, 2},
        {"a tie of three", {20, 11, 10}, 10},
        {"a late majority", {2, 2, 11, 11, 11}, 11},
    }));
    DYNAMIC_SECTION(c.name) {
        std::vector<Return> returns;
        for (const auto code : c.classes)
            returns.push_back({10 + 0.125 * static_cast<double>(returns.size()), code});
        CHECK(with_one(returns)->at(5, 7).ground.source_class == c.wanted);
    }
}

TEST_CASE("colours are means, rounded, of the points that have one",
          "[voxelserver][voxelize][columns]") {
    const std::vector<Return> returns{{10, kGroundClass, {10, 0, 255}},
                                      {10.5, kGroundClass, {11, 0, 255}},
                                      {20, kBuilding, {1, 2, 3}}};
    const auto coloured = with_one(returns, true);
    const auto plain = with_one(returns, false);
    CHECK((coloured->at(5, 7).ground.has_colour &&
           coloured->at(5, 7).ground.colour == voxel::Rgb8{11, 0, 255}));  // 10.5 rounds up
    CHECK((coloured->at(5, 7).roof.has_colour &&
           coloured->at(5, 7).roof.colour == voxel::Rgb8{1, 2, 3}));
    CHECK_FALSE(plain->at(5, 7).ground.has_colour);
    // A file with colours and one without over the same column: only the first one's count.
    const std::vector<store::VoxelPoint> a{point_at(5, 7, {10, kGroundClass, {100, 50, 0}})};
    const std::vector<store::VoxelPoint> b{point_at(5, 7, {10, kGroundClass, {0, 0, 0}})};
    const std::vector<PatchPoints> both{{a, true}, {b, false}};
    const auto mixed = init_columns(both, asprs(), 4);
    CHECK((mixed->at(5, 7).ground.has_colour &&
           mixed->at(5, 7).ground.colour == voxel::Rgb8{100, 50, 0} &&
           mixed->at(5, 7).ground_points == 2));
}

TEST_CASE("things above the ground are voxels by rising height",
          "[voxelserver][voxelize][columns]") {
    const auto patch = with_one({{10, kGroundClass},
                                 {12.25, kTree},
                                 {12.75, kTree},
                                 {12.5, kWire},
                                 {15, kTree},
                                 {15, kLow},
                                 {-3.5, 200},
                                 {99.999, kUnsorted}});
    const auto objects = patch->objects_at(5, 7);
    REQUIRE(objects.size() == 4);
    CHECK((objects[0].y == -4 && objects[0].source_class == 200 && objects[0].fraction == 128));
    CHECK((objects[1].y == 12 && objects[1].source_class == kTree && objects[1].fraction == 192));
    CHECK((objects[2].y == 15 && objects[2].source_class == kLow && objects[2].fraction == 0));
    CHECK(
        (objects[3].y == 99 && objects[3].source_class == kUnsorted && objects[3].fraction == 255));
    CHECK(patch->any_objects);
    for (int z = 0; z < 64; ++z)
        for (int x = 0; x < 64; ++x)
            if (x != 5 || z != 7)
                CHECK(patch->objects_at(x, z).empty());
}

TEST_CASE(
    "water cells hold means and counts of their columns; decks do not hide what is under them",
    "[voxelserver][voxelize][columns]") {
    struct Case {
        const char* name;
        int cell_voxels;
    };
    const auto c = GENERATE(values<Case>({{"one column", 1}, {"four", 4}, {"a whole patch", 64}}));
    DYNAMIC_SECTION(c.name) {
        std::vector<store::VoxelPoint> points;
        const auto add = [&](int x, int z, const Return& r) {
            points.push_back(point_at(x, z, r));
        };
        add(0, 0, {1, kGroundClass});
        add(0, 0, {4, kWater});
        add(0, 0, {9, kBridge});
        add(1, 0, {2, kGroundClass});
        add(1, 0, {20, kTree});
        add(63, 63, {30, kGroundClass});
        const PatchPoints source{points, false};
        const auto patch = init_columns({&source, 1}, asprs(), c.cell_voxels);
        REQUIRE(patch->cells.side == 64 / c.cell_voxels);
        const water::WaterCell& first = patch->cells.at(0, 0);
        CHECK(first.ground_points == (c.cell_voxels == 1 ? 1 : c.cell_voxels == 4 ? 2 : 3));
        CHECK(first.ground == (c.cell_voxels == 1 ? 1.0f : c.cell_voxels == 4 ? 1.5f : 11.0f));
        CHECK((first.water_points == 1 && first.water == 4));
        CHECK(first.other_points == (c.cell_voxels == 1 ? 0 : 1));
        const water::WaterCell& last = patch->cells.cells.back();
        CHECK(last.ground == (c.cell_voxels == 64 ? 11.0f : 30.0f));
    }
}

TEST_CASE("columns do not depend on the order of files, nor on how points were dealt into them",
          "[voxelserver][voxelize][columns]") {
    const unsigned seed = GENERATE(range(1u, 4u));
    const int rows = GENERATE(16, 1);  // a few returns in each column, or hundreds
    std::mt19937 random(seed);
    std::vector<store::VoxelPoint> points;
    for (int i = 0; i < 20'000; ++i) {
        const auto place = [&] { return static_cast<double>(random() % 1000) / 1000; };
        const std::uint8_t code = std::array<std::uint8_t, 8>{
            kGroundClass, 11, kBuilding, kWater, kBridge, kTree, kLow, 200}[random() % 8];
        points.push_back(
            point_at(static_cast<int>(random() % 64), static_cast<int>(random() % 16) % rows,
                     {static_cast<double>(random() % 400) / 10 - 5,
                      code,
                      {static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()), 0},
                      place(),
                      place()}));
    }
    const auto sorted = [](std::vector<store::VoxelPoint> v) {
        std::sort(v.begin(), v.end(), [](const auto& a, const auto& b) {
            return a.column() != b.column() ? a.column() < b.column() : a.y < b.y;
        });
        return v;
    };
    const auto whole = sorted(points);
    const PatchPoints one{whole, true};
    const auto reference = init_columns({&one, 1}, asprs(), 4);
    for (std::size_t files = 2; files <= 4; ++files) {
        std::vector<std::vector<store::VoxelPoint>> dealt(files);
        for (const auto& p : points)
            dealt[random() % files].push_back(p);
        std::vector<PatchPoints> sources;
        for (auto& d : dealt)
            d = sorted(d);
        for (auto& d : dealt)
            sources.push_back({d, true});
        INFO("seed " << seed << ", " << rows << " rows, " << files << " files");
        CHECK(same(*reference, *init_columns(sources, asprs(), 4)));
        std::reverse(sources.begin(), sources.end());
        CHECK(same(*reference, *init_columns(sources, asprs(), 4)));
    }
}
