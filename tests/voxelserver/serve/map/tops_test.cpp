#include <atomic>
#include <random>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/linear_light.hpp"
#include "tests/catch.hpp"
#include "tests/common/voxel/scene.hpp"
#include "tests/voxelserver/serve/map/png_pixels.hpp"
#include "voxelserver/serve/map/column_top.hpp"
#include "voxelserver/serve/map/pixels.hpp"
#include "voxelserver/serve/map/top_cache.hpp"

using namespace terravox;
using map::ColumnTop;
using voxel::Box;
using voxel::Material;
using voxel::VoxelAttr;

namespace {

/// Every material has a colour of its own.
map::TopColours test_colours() {
    map::TopColours out;
    std::uint8_t i = 0;
    for (auto& entry : out.palette.entries) {
        entry.colour = {static_cast<std::uint8_t>(10 * i), static_cast<std::uint8_t>(255 - 9 * i),
                        static_cast<std::uint8_t>(40 + i)};
        ++i;
    }
    return out;
}

using Boxes = std::vector<std::shared_ptr<const Box>>;

/// The highest voxel of a column, looked for one by one from the top.
std::optional<std::pair<std::int32_t, VoxelAttr>> plain_top(const Boxes& boxes, int x, int z) {
    std::optional<std::pair<std::int32_t, VoxelAttr>> out;
    for (const auto& box : boxes)
        for (int y = 0; box && y < voxel::kBoxSizeY; ++y)
            if (const auto attr = box->voxel(x, y, z);
                attr && (!out || box->key().by * 256 + y > out->first))
                out = {{box->key().by * 256 + y, *attr}};
    return out;
}

VoxelAttr of(Material material, std::optional<voxel::Rgb8> colour = {}) {
    VoxelAttr out;
    out.material = material;
    if (colour) {
        out.flags = VoxelAttr::kHasColour;
        out.colour = *colour;
    }
    return out;
}

/// One level slab of one kind.
std::shared_ptr<const Box> slab(std::int32_t by, int height, const VoxelAttr& attr) {
    test::Scene scene;
    for (int z = -1; z <= 64; ++z)
        for (int x = -1; x <= 64; ++x)
            scene.add(x, z, -1, height, true);
    return scene.build({0, 0, by, 0}, [&](int, int, int) { return attr; });
}

std::uint32_t measure_shade(const std::array<std::int32_t, 9>& heights) {
    std::array<ColumnTop, 9> tops;
    map::TopWindow window{};
    for (std::size_t i = 0; i < 9; ++i) {
        tops[i] = {heights[i], {}, Material::kGround};
        window[i] = &tops[i];
    }
    return map::hill_shade(window);
}

}  // namespace

TEST_CASE("a box column from above is what its columns show from the top", "[map][top]") {
    const auto colours = test_colours();
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        Boxes boxes;
        for (std::int32_t by = -2; by < static_cast<std::int32_t>(seed % 3); ++by)
            boxes.push_back(test::random_scene(seed * 10 + static_cast<std::uint64_t>(by + 2))
                                .build({0, -5, by, 7}, test::to_attr));
        if (seed % 2 == 0)
            std::swap(boxes.front(), boxes.back());
        boxes.insert(boxes.begin() + 1, nullptr);
        const auto top = map::make_top(boxes, colours);
        REQUIRE(top);
        int wrong = 0;
        for (int z = 0; z < 64; ++z)
            for (int x = 0; x < 64; ++x) {
                const auto expected = plain_top(boxes, x, z);
                const map::ColumnTop& got = top->at(x, z);
                if (!expected)
                    wrong += got.nothing() ? 0 : 1;
                else
                    wrong += got.y == expected->first && got.material == expected->second.material
                                 ? 0
                                 : 1;
            }
        INFO("seed " << seed);
        CHECK(wrong == 0);
    }
}

TEST_CASE("true colours are mixed into those of materials in linear light", "[map][top]") {
    const auto colours = test_colours();
    const auto to_colour = [&](const VoxelAttr& attr) {
        return map::make_top(Boxes{slab(0, 9, attr)}, colours)->at(3, 60).colour;
    };
    CHECK(to_colour(of(Material::kRoad)) == colours.palette.of(Material::kRoad).colour);
    const voxel::Rgb8 shown{200, 30, 90};
    struct Case {
        Material material;
        int percent;
    };
    for (const auto [material, percent] : {Case{Material::kRoad, 85}, Case{Material::kWater, 45}}) {
        const auto plain = colours.palette.of(material).colour;
        const auto mixed = [&](std::uint8_t a, std::uint8_t b) {
            const double linear =
                util::to_linear(a) * (100 - percent) / 100.0 + util::to_linear(b) * percent / 100.0;
            return util::to_srgb(static_cast<std::uint32_t>(linear + 0.5));
        };
        CHECK(to_colour(of(material, shown)) == voxel::Rgb8{mixed(plain.r, shown.r),
                                                            mixed(plain.g, shown.g),
                                                            mixed(plain.b, shown.b)});
    }
}

TEST_CASE("hidden rock under the sky of its box is still a top", "[map][top]") {
    // The margin says that a box above goes on, but that box is not given: bricks and larger cells
    // without detail are met.
    test::Scene scene;
    for (int z = -1; z <= 64; ++z)
        for (int x = -1; x <= 64; ++x)
            scene.add(x, z, -1, 257, true);
    const auto box = scene.build({0, 0, -1, 0}, test::to_attr);
    const auto top = map::make_top(Boxes{box}, test_colours());
    REQUIRE(top);
    CHECK(top->at(0, 0).y == -1);
    CHECK(top->at(63, 31).material == Material::kRock);
}

TEST_CASE("nothing is nothing, and what calls itself air is still seen", "[map][top]") {
    const auto colours = test_colours();
    CHECK(map::make_top({}, colours) == nullptr);
    CHECK(map::make_top(Boxes{nullptr, nullptr}, colours) == nullptr);
    CHECK(map::make_top(Boxes{slab(0, 9, of(Material::kAir))}, colours)->at(0, 0).material ==
          Material::kUnknown);
}

TEST_CASE("boxes that do not stand on each other are refused", "[map][top]") {
    const auto colours = test_colours();
    const auto build = [](const voxel::BoxKey& key) {
        return test::random_scene(1).build(key, test::to_attr);
    };
    CHECK_THROWS_AS(map::make_top(Boxes{build({0, 0, 0, 0}), build({0, 1, 1, 0})}, colours),
                    util::Error);
    CHECK_THROWS_AS(map::make_top(Boxes{build({0, 0, 0, 0}), build({0, 0, 1, -1})}, colours),
                    util::Error);
    CHECK_THROWS_WITH(map::make_top(Boxes{build({1, 0, 0, 0})}, colours),
                      test::contains("1/0/0/0"));
}

namespace {

/// Columns made of one random box each; at hand only when `at_hand` says so.
struct Maker {
    std::atomic<int> made{0};
    std::atomic<int> looked{0};
    std::atomic<bool> at_hand{false};
    std::optional<map::ColumnBoxes> operator()(std::int32_t bx, std::int32_t bz, bool make) {
        ++looked;
        if (!make && !at_hand)
            return std::nullopt;
        if (make)
            ++made;
        return map::ColumnBoxes{
            {test::random_scene(static_cast<std::uint64_t>(bx + 100 * bz + 5000))
                 .build({0, bx, 0, bz}, test::to_attr)},
            {bx - 2, bz - 2, bx + 3, bz + 3}};
    }
};

map::FetchColumn fetch_from(Maker& maker) {
    return [&maker](std::int32_t bx, std::int32_t bz, bool make) { return maker(bx, bz, make); };
}

}  // namespace

TEST_CASE("a column is made once, and only when it shall be made", "[map][top-cache]") {
    Maker maker;
    map::TopCache cache(fetch_from(maker), test_colours(), 4, std::size_t{1} << 20);
    CHECK_FALSE(cache.top(3, -4, false).known);
    CHECK(cache.version({0, 0, -1}) == 0);
    const auto top = cache.top(3, -4, true);
    REQUIRE(top.top);
    CHECK(top.known);
    CHECK(top.reach == voxel::InputExtent{1, -6, 6, -1});
    CHECK(cache.top(3, -4, false).top == top.top);
    CHECK(cache.top(3, -4, true).top == top.top);
    CHECK(maker.made == 1);
}

TEST_CASE("versions grow for every tile that shows a column or shades by it", "[map][top-cache]") {
    Maker maker;
    map::TopCache cache(fetch_from(maker), test_colours(), 3, std::size_t{1} << 20);
    cache.note_made(3, -4);  // the north-eastern corner of tile (0, -1): its neighbours to the
                             // north and east look at it
    struct Case {
        map::TileArea area;
        bool changed;
    };
    const Case cases[] = {{{0, 0, -1}, true}, {{0, 1, -1}, true},   {{0, 0, -2}, true},
                          {{0, 1, -2}, true}, {{0, -1, -1}, false}, {{0, 0, 0}, false},
                          {{1, 0, -1}, true}, {{1, 1, -1}, false},  {{2, 0, -1}, true},
                          {{2, 0, 0}, false}, {{3, 0, -1}, false}};
    for (const auto& c : cases) {
        INFO("area " << c.area.zooms_out << "/" << c.area.x << "/" << c.area.z);
        CHECK((cache.version(c.area) != 0) == c.changed);
    }
    const auto before = cache.version({2, 0, -1});
    cache.note_made(0, -1);
    CHECK(cache.version({2, 0, -1}) > before);
}

TEST_CASE("columns at the ends of all numbers are noted too", "[map][top-cache]") {
    map::MadeAreas areas(21);
    areas.add(INT32_MIN, INT32_MAX);
    areas.add(INT32_MAX, INT32_MIN);
    CHECK(areas.version({0, INT32_MIN >> 2, INT32_MAX >> 2}) == 1);
    CHECK(areas.version({20, -512, -512}) == 0);
    CHECK(areas.version({20, 511, -512}) == 2);
}

TEST_CASE("boxes made by other requests are shown, and evicted columns are requested again",
          "[map][top-cache]") {
    Maker maker;
    map::TopCache cache(fetch_from(maker), test_colours(), 4,
                        std::size_t{100} << 10);  // three columns
    maker.at_hand = true;
    std::vector<std::shared_ptr<const map::BoxTop>> tops;
    for (int i = 0; i < 6; ++i)
        tops.push_back(cache.top(i, 0, false).top);
    CHECK(maker.made == 0);
    CHECK(cache.stats().bytes <= std::size_t{100} << 10);
    for (std::size_t i = 0; i < 6; ++i)
        CHECK(cache.top(static_cast<int>(i), 0, true).top->columns == tops[i]->columns);
    CHECK(maker.made > 0);
}

TEST_CASE("slopes towards the north-west are bright, those away from it dark", "[map][shade]") {
    struct Case {
        const char* name;
        std::array<std::int32_t, 9> heights;
        int sign;
    };
    const auto c = GENERATE(values<Case>({
        {"level", {5, 5, 5, 5, 5, 5, 5, 5, 5}, 0},
        {"rises to the east: faces west", {0, 1, 2, 0, 1, 2, 0, 1, 2}, 1},
        {"rises to the west", {2, 1, 0, 2, 1, 0, 2, 1, 0}, -1},
        {"rises to the south: faces north", {0, 0, 0, 1, 1, 1, 2, 2, 2}, 1},
        {"rises to the north", {2, 2, 2, 1, 1, 1, 0, 0, 0}, -1},
        {"rises to the south-east", {0, 1, 2, 1, 2, 3, 2, 3, 4}, 1},
        {"rises to the north-west", {4, 3, 2, 3, 2, 1, 2, 1, 0}, -1},
        {"a wall", {0, 0, 0, 0, 0, 0, -90, -90, -90}, -1},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto shade = static_cast<int>(measure_shade(c.heights));
        const int flat = map::kFlatShade;
        CHECK((shade > flat) - (shade < flat) == c.sign);
    }
}

TEST_CASE("shade stays within its range for any heights", "[map][shade]") {
    std::mt19937_64 random(3);
    for (int i = 0; i < 20000; ++i) {
        std::array<std::int32_t, 9> heights;
        for (auto& h : heights)
            h = i % 2 == 0 ? static_cast<std::int32_t>(random())
                           : static_cast<std::int32_t>(random() % 7);
        const std::uint32_t shade = measure_shade(heights);
        INFO("round " << i);
        REQUIRE(shade >= map::kFlatShade * 6 / 10);
        REQUIRE(shade <= map::kFlatShade * 5 / 4);
    }
    CHECK(measure_shade({INT32_MIN, INT32_MIN, INT32_MIN, INT32_MAX, INT32_MAX, INT32_MAX,
                         INT32_MIN, 0, INT32_MAX}) > 0);
}

TEST_CASE(
    "water is not shaded, nothing is transparent, and nothing next to a column is level with it",
    "[map][shade]") {
    std::array<ColumnTop, 9> tops;
    map::TopWindow window{};
    for (std::size_t i = 0; i < 9; ++i) {
        tops[i] = {static_cast<std::int32_t>(i % 3), {90, 120, 60}, Material::kGrass};
        window[i] = &tops[i];
    }
    const map::Rgba8 lit = map::shaded_pixel(window);
    CHECK(lit.r > 90);
    CHECK(lit.a == 255);
    for (std::size_t i = 0; i < 9; ++i)
        if (i != 4)
            tops[i].material = Material::kAir;
    CHECK(map::shaded_pixel(window) == map::Rgba8{90, 120, 60, 255});
    for (auto& top : tops)
        top.material = Material::kWater;
    CHECK(map::shaded_pixel(window) == map::Rgba8{90, 120, 60, 255});
    tops[4].material = Material::kAir;
    CHECK(map::shaded_pixel(window) == map::Rgba8{});
}
