#include "voxelserver/serve/map/map_tiles.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <thread>

#include "common/util/linear_light.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/serve/map/made_up_land.hpp"
#include "tests/voxelserver/serve/map/png_pixels.hpp"

using namespace terravox;
using map::MapTiles;
using map::Rgba8;
using test::MadeUpLand;

namespace {

constexpr std::size_t kRoom = std::size_t{64} << 20;

/// Box columns from (min) to (max), half-open.
voxel::WorldInfo make_world(int levels, std::int32_t min_bx, std::int32_t min_bz,
                            std::int32_t max_bx, std::int32_t max_bz) {
    voxel::WorldInfo info;
    info.levels = levels;
    info.bounds = {{min_bx * 64, -500, min_bz * 64}, {max_bx * 64, 500, max_bz * 64}};
    return info;
}

/// What a column shows in a world of these bounds, where nothing is missing.
map::ColumnTop column_in(const voxel::WorldInfo& info, std::int32_t x, std::int32_t z) {
    const auto& b = info.bounds;
    if (x < b.min[0] || x >= b.max[0] || z < b.min[2] || z >= b.max[2] ||
        MadeUpLand::empty_column(x >> 6, z >> 6))
        return {};
    return test::land_at(x, z);
}

/// A pixel of the finest zoom, without tiles.
Rgba8 plain_pixel(const voxel::WorldInfo& info, std::int32_t x, std::int32_t z) {
    std::array<map::ColumnTop, 9> tops;
    map::TopWindow window{};
    for (int i = 0; i < 9; ++i) {
        const auto at = static_cast<std::size_t>(i);
        tops[at] = column_in(info, x + i % 3 - 1, z + i / 3 - 1);
        window[at] = &tops[at];
    }
    return map::shaded_pixel(window);
}

std::vector<Rgba8> read_pixels(const map::Tile& tile) {
    return tile.png ? test::read_png(*tile.png).pixels : std::vector<Rgba8>(std::size_t{256} * 256);
}

int differing(const std::vector<Rgba8>& a, const std::vector<Rgba8>& b) {
    int out = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        out += a[i] == b[i] ? 0 : 1;
    return out;
}

}  // namespace

TEST_CASE("finest tiles are the shaded land, without seams at boxes and tiles", "[map][tiles]") {
    const auto info = make_world(4, -6, -5, 7, 6);
    MadeUpLand land(4);
    MapTiles tiles(info, land, kRoom);
    for (std::int32_t ty = -3; ty <= 2; ++ty)
        for (std::int32_t tx = -3; tx <= 2; ++tx) {
            const auto tile = tiles.get(3, tx, ty);
            std::vector<Rgba8> expected;
            for (int i = 0; i < 256 * 256; ++i)
                expected.push_back(plain_pixel(info, tx * 256 + i % 256, ty * 256 + i / 256));
            INFO("tile " << tx << "/" << ty);
            CHECK(tile.complete);
            CHECK(differing(read_pixels(tile), expected) == 0);
        }
}

TEST_CASE("coarser tiles are means of four in linear light, weighted by alpha", "[map][tiles]") {
    const auto info = make_world(5, -8, -8, 9, 10);
    MadeUpLand land(5);
    MapTiles tiles(info, land, kRoom);
    for (const int zoom : {3, 2}) {
        const int t = -1;
        const auto coarse = read_pixels(tiles.get(zoom, t, t));
        int wrong = 0;
        int seen = 0;
        std::array<std::vector<Rgba8>, 4> fine;
        for (int q = 0; q < 4; ++q)
            fine[static_cast<std::size_t>(q)] =
                read_pixels(tiles.get(zoom + 1, 2 * t + q % 2, 2 * t + q / 2));
        for (int i = 0; i < 256 * 256; ++i) {
            const int x = i % 256 * 2;
            const int z = i / 256 * 2;
            double alpha = 0, sums[3] = {};
            for (int k = 0; k < 4; ++k) {
                const int fx = x + k % 2;
                const int fz = z + k / 2;
                const Rgba8 p = fine[static_cast<std::size_t>(fz / 256 * 2 + fx / 256)]
                                    [static_cast<std::size_t>(fz % 256 * 256 + fx % 256)];
                alpha += p.a;
                sums[0] += p.a * double(util::to_linear(p.r));
                sums[1] += p.a * double(util::to_linear(p.g));
                sums[2] += p.a * double(util::to_linear(p.b));
            }
            const Rgba8 got = coarse[static_cast<std::size_t>(i)];
            const auto channel = [&](int c) {
                return util::to_srgb(static_cast<std::uint32_t>(std::floor(sums[c] / alpha + 0.5)));
            };
            const Rgba8 expected = alpha == 0 ? Rgba8{}
                                              : Rgba8{channel(0), channel(1), channel(2),
                                                      static_cast<std::uint8_t>((alpha + 2) / 4)};
            wrong += got == expected ? 0 : 1;
            seen += got.a != 0 && got.a != 255 ? 1 : 0;
        }
        INFO("zoom " << zoom);
        CHECK(wrong == 0);
        CHECK(seen > 0);  // edges that are half transparent
    }
}

TEST_CASE("bytes do not depend on earlier requests, on the cache, or on threads", "[map][tiles]") {
    const auto info = make_world(6, -9, -9, 9, 9);
    std::map<std::array<int, 3>, std::string> expected;
    std::vector<std::array<int, 3>> order;
    for (const int zoom : {5, 4, 3})
        for (int y = -2; y < 1; ++y)
            for (int x = -2; x < 2; ++x)
                order.push_back({zoom, x, y});
    const auto measure_bytes = [](MapTiles& tiles, const std::array<int, 3>& at) {
        const auto tile = tiles.get(at[0], at[1], at[2]);
        return tile.complete ? (tile.png ? *tile.png : "nothing") : "incomplete";
    };
    for (const auto& at : order) {  // each from nothing
        MadeUpLand land(6);
        MapTiles tiles(info, land, 0);
        expected[at] = measure_bytes(tiles, at);
    }
    for (const std::size_t room : {std::size_t{0}, std::size_t{1} << 20}) {
        MadeUpLand land(6);
        MapTiles tiles(info, land, room);
        std::atomic<int> wrong = 0;
        std::vector<std::thread> threads;
        for (unsigned t = 0; t < 3; ++t)
            threads.emplace_back([&, t] {
                auto mine = order;
                std::shuffle(mine.begin(), mine.end(), std::mt19937_64(t));
                mine.resize(18);
                for (const auto& at : mine)
                    wrong += measure_bytes(tiles, at) == expected.at(at) ? 0 : 1;
            });
        for (auto& thread : threads)
            thread.join();
        CHECK(wrong == 0);
        CHECK(tiles.pixel_stats().bytes + tiles.png_stats().bytes <= room);
    }
}

TEST_CASE("coarse zooms show what is at hand and make nothing", "[map][tiles]") {
    const auto info = make_world(6, 0, 0, 128, 128);
    MadeUpLand land(6);
    MapTiles tiles(info, land, kRoom);
    const auto nothing = tiles.get(0, 0, 0);
    CHECK_FALSE(nothing.complete);
    CHECK(nothing.png == nullptr);
    CHECK(land.requests == 0);

    REQUIRE(tiles.get(5, 3, 2).complete);
    const auto made = land.made();
    CHECK(made.size() == 36);
    const auto some = tiles.get(0, 0, 0);
    CHECK_FALSE(some.complete);
    REQUIRE(some.png);
    const auto pixels = read_pixels(some);
    int inside = 0, outside = 0;  // of the tile's 8 x 8 pixels
    for (int i = 0; i < 256 * 256; ++i) {
        const bool in_tile = i % 256 / 8 == 3 && i / 256 / 8 == 2;
        (in_tile ? inside : outside) += pixels[static_cast<std::size_t>(i)].a != 0 ? 1 : 0;
    }
    CHECK(inside > 40);
    CHECK(outside > 0);                   // the ring around it
    CHECK(outside <= 4 * 8 * 2 + 4 * 4);  // two pixels wide
    CHECK(land.made() == made);

    // Nothing new: nothing is requested again. Something new: only around it.
    const int requests = land.requests;
    CHECK(*tiles.get(0, 0, 0).png == *some.png);
    CHECK(land.requests == requests);
    static_cast<void>(land.top(100, 100, true));
    CHECK(*tiles.get(0, 0, 0).png != *some.png);
    CHECK(land.requests - requests <= 1 + 4 * 36);
}

TEST_CASE("an overview is complete when everything has been made", "[map][tiles]") {
    const auto info = make_world(5, -7, 3, 9, 20);
    MadeUpLand land(5);
    MapTiles tiles(info, land, kRoom);
    for (std::int32_t bz = 3; bz < 20; ++bz)
        for (std::int32_t bx = -7; bx < 9; ++bx)
            static_cast<void>(land.top(bx, bz, true));
    const auto overview = tiles.get(0, 0, 0);
    CHECK(overview.complete);
    REQUIRE(overview.png);
    CHECK(overview.reach ==
          voxel::InputExtent{-1, 3, 9, 20});  // with the column that shading looked at
    MapTiles others(info, land, 0);
    CHECK(*others.get(0, 0, 0).png == *overview.png);

    // Box columns that are gone, and made again one by one, take nothing from it.
    land.forget_all();
    static_cast<void>(land.top(0, 5, true));
    const auto later = tiles.get(0, 0, 0);
    CHECK(later.complete);
    REQUIRE(later.png);
    CHECK(*later.png == *overview.png);
    CHECK(tiles.get(4, 0, 3).complete);
    CHECK(land.made().size() == 1);  // the finest tile was seen whole before
}

TEST_CASE("one call makes a bounded number of pictures, and the next go on from there",
          "[map][tiles]") {
    const int side = 96;  // 24 x 24 finest tiles
    const auto info = make_world(8, 0, 0, side, side);
    MadeUpLand land(8, true);
    for (std::int32_t bz = 0; bz < side; ++bz)
        for (std::int32_t bx = 0; bx < side; ++bx)
            static_cast<void>(land.top(bx, bz, true));
    MapTiles tiles(info, land, std::size_t{256} << 20);
    int calls = 0;
    bool complete = false;
    while (!complete && calls < 100) {
        const int requests = land.requests;
        complete = tiles.get(0, 0, 0).complete;
        CHECK(land.requests - requests <= MapTiles::kMaxTiles * 36);
        ++calls;
    }
    CHECK(complete);
    CHECK(calls > 3);
    CHECK(calls < 8);
}

TEST_CASE("tiles outside the world are empty and complete, and cost nothing", "[map][tiles]") {
    MadeUpLand land(21);
    const auto info = make_world(21, -10, -10, 10, 10);
    MapTiles tiles(info, land, kRoom);
    for (const int zoom : {0, 1, 10, 18, 19, 20})
        for (const std::int32_t x :
             {INT32_MIN, INT32_MIN + 1, -1000000, 1000000, INT32_MAX - 1, INT32_MAX})
            for (const std::int32_t y : {INT32_MIN, 0, INT32_MAX}) {
                const auto tile = tiles.get(zoom, x, y);
                CHECK(tile.complete);
                CHECK(tile.png == nullptr);
                CHECK(tile.reach.empty());
            }
    CHECK(land.requests == 0);
    for (const int zoom : {-1, 21, INT_MAX, INT_MIN})
        CHECK_THROWS_AS(tiles.get(zoom, 0, 0), util::UsageError);
    CHECK_THROWS_WITH(tiles.get(21, 0, 0), test::contains("allowed: 0 to 20"));

    MapTiles none({}, land, kRoom);
    CHECK(none.zooms() == 1);
    CHECK(none.get(0, 0, 0).complete);
}

TEST_CASE("a world as large as numbers go is drawn with bounded work", "[map][tiles]") {
    voxel::WorldInfo info;
    info.levels = 21;
    info.bounds = {{INT32_MIN, INT32_MIN, INT32_MIN}, {INT32_MAX, INT32_MAX, INT32_MAX}};
    MadeUpLand land(21);
    MapTiles tiles(info, land, kRoom);
    std::mt19937_64 random(2);
    for (int i = 0; i < 150; ++i)
        static_cast<void>(land.top(static_cast<std::int32_t>(random() % 60000000) - 30000000,
                                   static_cast<std::int32_t>(random() % 60000000) - 30000000,
                                   true));
    for (const std::int32_t corner : {INT32_MIN >> 6, INT32_MAX >> 6})
        static_cast<void>(land.top(corner, corner, true));
    const int requests = land.requests;
    for (int y = -2; y < 2; ++y)
        for (int x = -2; x < 2; ++x)
            CHECK_FALSE(tiles.get(0, x, y).complete);
    CHECK(land.requests - requests <= 16 * MapTiles::kMaxTiles * 36);
    CHECK(tiles.get(20, INT32_MAX / 256, INT32_MAX / 256).complete);
    CHECK(tiles.get(20, INT32_MIN / 256, INT32_MIN / 256).complete);
}

TEST_CASE("what cannot be made is an error, and made when it can be", "[map][tiles]") {
    const auto info = make_world(4, -10, -10, 10, 10);
    MadeUpLand land(4);
    land.failing = {{4, 1}};  // in the ring of tile (0, 0), and in tile (1, 0)
    MapTiles tiles(info, land, kRoom);
    CHECK_THROWS_WITH(tiles.get(3, 0, 0), test::contains("damaged"));
    CHECK_THROWS_WITH(tiles.get(2, 0, 0), test::contains("damaged"));
    CHECK(tiles.get(3, -1, 0).complete);
    const auto overview = tiles.get(0, 0, 0);
    CHECK_FALSE(overview.complete);
    land.failing.clear();
    CHECK(tiles.get(3, 0, 0).complete);
    CHECK(tiles.get(2, 0, 0).complete);
}
