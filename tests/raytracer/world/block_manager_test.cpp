#include "raytracer/world/block_manager.hpp"

#include <algorithm>
#include <thread>

#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using terravox::test::ArrayWorld;
using terravox::test::landscape;

namespace {

constexpr std::size_t kPlenty = std::size_t{256} << 20;

}  // namespace

TEST_CASE("a box that cannot be had is a hole, counted once; the others are there", "[raytracer][world]") {
    const auto world = landscape();
    world->make_hole({0, 0, 0, -1});
    BlockManager blocks(*world, kPlenty);
    const auto range = voxel::boxes_over(world->level_bounds(), 0);
    int holes = 0, boxes = 0;
    for (int round = 0; round < 3; ++round)
        for (int bx = range.min.bx; bx < range.max.bx; ++bx)
            for (int by = range.min.by; by < range.max.by; ++by)
                for (int bz = range.min.bz; bz < range.max.bz; ++bz) {
                    const BlockRef ref = blocks.get({0, bx, by, bz});
                    CHECK(ref.hole == (bx == 0 && by == 0 && bz == -1));
                    CHECK_FALSE((ref.hole && ref.box));
                    holes += ref.hole ? 1 : 0, boxes += ref.box ? 1 : 0;
                }
    CHECK(blocks.hole_count() == 1);
    CHECK(holes == 3);
    CHECK(boxes > 30);
}

TEST_CASE("holes are counted once, however often and by however many threads they are met", "[raytracer][world]") {
    const auto world = landscape();
    world->make_hole({0, 0, 0, 0});
    world->make_hole({0, -1, 0, 0});
    BlockManager blocks(*world, 1);  // nothing fits: every meeting asks the world again
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            for (int i = 0; i < 50; ++i) (void)blocks.get({0, -(i % 2), 0, 0});
        });
    for (auto& t : threads) t.join();
    CHECK(blocks.hole_count() == 2);
    CHECK(world->asked() >= 2);
}

TEST_CASE("fetching ahead makes every box once, so that a walk asks the world for nothing", "[raytracer][world]") {
    const auto world = landscape();
    BlockManager blocks(*world, kPlenty);
    const std::atomic<bool> stop{false};
    blocks.prefetch(0, world->info().bounds, 2, stop);
    const auto range = voxel::boxes_over(world->info().bounds, 0);
    const int all = (range.max.bx - range.min.bx) * (range.max.by - range.min.by) * (range.max.bz - range.min.bz);
    CHECK(world->asked() == all);
    for (int bx = range.min.bx; bx < range.max.bx; ++bx) (void)blocks.get({0, bx, 0, 0});
    CHECK(world->asked() == all);
}

TEST_CASE("fetching ahead ends when asked to, and when memory is nearly full", "[raytracer][world]") {
    const auto world = landscape();
    SECTION("asked to stop") {
        BlockManager blocks(*world, kPlenty);
        const std::atomic<bool> stop{true};
        blocks.prefetch(0, world->info().bounds, 2, stop);
        CHECK(world->asked() == 0);
    }
    SECTION("memory") {
        constexpr std::size_t kLittle = 40'000;
        BlockManager blocks(*world, kLittle);
        const std::atomic<bool> stop{false};
        blocks.prefetch(0, world->info().bounds, 1, stop);
        const auto range = voxel::boxes_over(world->info().bounds, 0);
        const int all = (range.max.bx - range.min.bx) * (range.max.by - range.min.by) * (range.max.bz - range.min.bz);
        CHECK(world->asked() < all);
        CHECK(blocks.stats().bytes <= kLittle);
    }
}

TEST_CASE("the hash of box keys tells levels and neighbours apart", "[raytracer][world]") {
    std::vector<std::size_t> hashes;
    const voxel::BoxKeyHash hash;
    for (int level = 0; level < 8; ++level)
        for (int bx = -6; bx < 6; ++bx)
            for (int by = -2; by < 3; ++by)
                for (int bz = -6; bz < 6; ++bz) hashes.push_back(hash({level, bx, by, bz}));
    std::sort(hashes.begin(), hashes.end());
    CHECK(std::adjacent_find(hashes.begin(), hashes.end()) == hashes.end());
}
