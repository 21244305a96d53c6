#include <algorithm>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/serve/gkot/box_grid.hpp"
#include "voxelserver/serve/gkot/gkot_reply.hpp"

using namespace terravox;
using gkot::Region;
using test::BoxGrid;

namespace {

std::size_t compute_index(const Region& r, int x, int y, int z) {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(z) * static_cast<std::size_t>(r.sx) +
           static_cast<std::size_t>(y) * static_cast<std::size_t>(r.sx) *
               static_cast<std::size_t>(r.sz);
}

/// Word by word, as slowly and plainly as can be.
std::vector<std::uint32_t> plain_blocks(const BoxGrid& grid, const Region& r) {
    std::vector<std::uint32_t> out(static_cast<std::size_t>(r.sx * r.sy * r.sz));
    for (int y = 0; y < r.sy; ++y)
        for (int z = 0; z < r.sz; ++z)
            for (int x = 0; x < r.sx; ++x)
                if (const auto attr = grid.voxel(r.x + x, r.y + y, r.z + z))
                    out[compute_index(r, x, y, z)] = gkot::block_word(attr->material);
    return out;
}

}  // namespace

TEST_CASE("blocks are the voxels of the world, wherever the region lies", "[gkot][box]") {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        BoxGrid grid(seed);
        std::mt19937_64 random(seed);
        for (int round = 0; round < 12; ++round) {
            Region r;
            r.sx = 1 << random() % 8;
            r.sy = 1 << random() % 9;
            r.sz = 1 << random() % 8;
            r.x = static_cast<int>(random() % 300) - 180;
            r.y = static_cast<int>(random() % 900) - 500;
            r.z = static_cast<int>(random() % 300) - 180;
            INFO("seed " << seed << ", region " << r.x << " " << r.y << " " << r.z << ", sizes "
                         << r.sx << " " << r.sy << " " << r.sz);
            CHECK(gkot::read_blocks(grid.info.bounds, r, grid.fetch()) == plain_blocks(grid, r));
        }
        CHECK(grid.requests_outside == 0);
    }
}

TEST_CASE("regions at the ends of all numbers are air, and nothing is requested", "[gkot][box]") {
    BoxGrid grid(1);
    constexpr std::int64_t kEnds[] = {
        INT64_MIN, INT64_MIN + 511, INT64_MAX, INT64_MAX - 511, std::int64_t{INT32_MIN} - 512,
        INT32_MAX, -64 - 16,        64};
    for (const auto x : kEnds)
        for (const auto z : kEnds) {
            const auto blocks =
                gkot::read_blocks(grid.info.bounds, {x, x, z, 16, 16, 16}, grid.fetch());
            CHECK(std::ranges::all_of(blocks, [](auto word) { return word == 0; }));
        }
    CHECK(grid.requests == 0);
    // A world that reaches to the ends itself.
    const voxel::VoxelBounds all{{INT32_MIN, INT32_MIN, INT32_MIN},
                                 {INT32_MAX, INT32_MAX, INT32_MAX}};
    for (const std::int64_t at :
         {std::int64_t{INT32_MIN} - 8, std::int64_t{INT32_MAX} - 8, INT64_MIN, INT64_MAX})
        CHECK(gkot::read_blocks(all, {at, at, at, 16, 16, 16}, grid.fetch()).size() == 4096);
    CHECK(gkot::read_blocks({}, {0, 0, 0, 4, 4, 4}, grid.fetch()) ==
          std::vector<std::uint32_t>(64));
}

TEST_CASE("a box that cannot be made is an error, not air", "[gkot][box]") {
    BoxGrid grid(1);
    const gkot::FetchBox broken = [](const voxel::BoxKey&) -> std::shared_ptr<const voxel::Box> {
        throw util::Error("the square is damaged");
    };
    CHECK_THROWS_WITH(gkot::read_blocks(grid.info.bounds, {0, 0, 0, 16, 16, 16}, broken),
                      test::contains("damaged"));
}

TEST_CASE("the origin reports the lowest and highest tops around it", "[gkot][origin]") {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        BoxGrid grid(seed);
        int low = INT32_MAX;
        int high = INT32_MIN;
        for (int z = -64; z < 0; ++z)
            for (int x = 0; x < 64; ++x)
                for (int y = 255; y >= -256; --y)
                    if (grid.voxel(x, y, z)) {
                        low = std::min(low, y);
                        high = std::max(high, y);
                        break;
                    }
        const auto origin = gkot::find_origin(grid.info, {5.5, 30}, grid.fetch());
        INFO("seed " << seed);
        CHECK(origin.tmz == low);
        CHECK(origin.zmin == low);
        CHECK(origin.zmax == high);
        CHECK(origin.zrange == high - low);
        CHECK(grid.requests_outside == 0);
    }
}

TEST_CASE("a box without a height is the same as one with the height that the origin reports",
          "[gkot][origin]") {
    for (const double voxel_m : {1.0, 0.1, 0.3, 2.0}) {
        BoxGrid grid(2);
        grid.info.voxel_m = grid.info.crs_units_per_voxel = voxel_m;
        gkot::BoxRequest request;
        request.sx = request.sy = request.sz = 64;
        for (const double tmx : {-50 * voxel_m, 20 * voxel_m, 1e6}) {
            request.origin = {tmx, 3};
            request.tmz.reset();
            const auto automatic = gkot::find_region(grid.info, request, grid.fetch());
            request.tmz = gkot::find_origin(grid.info, request.origin, grid.fetch()).tmz;
            INFO("voxels of " << voxel_m << " m, tmx " << tmx);
            CHECK(gkot::find_region(grid.info, request, grid.fetch()).y == automatic.y);
        }
    }
}

TEST_CASE(
    "where nothing is around the origin the whole world counts, and -1 where nothing is at all",
    "[gkot][origin]") {
    BoxGrid grid(2);
    const auto far = gkot::find_origin(grid.info, {1e8, 0}, grid.fetch());
    CHECK(far.tmz == -256);
    CHECK(far.zmin == -256);
    CHECK(far.zmax == 255);
    CHECK(far.zrange == 511);
    const auto none = gkot::find_origin({}, {1, 2}, grid.fetch());
    CHECK(gkot::to_json(none) == R"({"tmx":1,"tmy":2,"tmz":-1,"zmin":-1,"zmax":-1,"zrange":0})");
    CHECK(grid.requests == 0);
}

TEST_CASE("reported heights lead back to their voxel", "[gkot][origin]") {
    std::mt19937_64 random(5);
    for (int i = 0; i < 20000; ++i) {
        const auto y = static_cast<std::int64_t>(random() % 2000000) - 1000000;
        const double voxel_m = 0.01 + static_cast<double>(random() % 100000) / 20000;
        INFO("y " << y << ", voxel_m " << voxel_m);
        REQUIRE(gkot::find_voxel(gkot::find_height(y, voxel_m), voxel_m) == y);
    }
}

TEST_CASE("numbers of the origin are written so that they read back", "[gkot][origin]") {
    gkot::Origin origin;
    origin.tmx = 462000.25;
    origin.tmy = -0.0;
    origin.tmz = 0.30000000000000004;
    origin.zmin = -12;
    origin.zmax = 1e9;
    origin.zrange = 3;
    CHECK(gkot::to_json(origin) == R"({"tmx":462000.25,"tmy":0,"tmz":0.30000000000000004,)"
                                   R"("zmin":-12,"zmax":1000000000,"zrange":3})");
    origin.tmx = -1.7976931348623157e308;  // longer than any origin that can be requested
    CHECK(gkot::to_json(origin).size() > 300);
}
