#include "voxelserver/serve/map/top_cache.hpp"

#include <atomic>

#include "tests/catch.hpp"
#include "tests/common/voxel/scene.hpp"
#include "tests/voxelserver/serve/map/colours.hpp"

using namespace terravox;

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
    map::TopCache cache(fetch_from(maker), test::test_colours(), 4, std::size_t{1} << 20);
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
    map::TopCache cache(fetch_from(maker), test::test_colours(), 3, std::size_t{1} << 20);
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
    map::TopCache cache(fetch_from(maker), test::test_colours(), 4,
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
