#include "raytracer/core/blocks/block_manager.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <thread>

#include "common/voxel/world.hpp"
#include "raytracer/farm/render/passes/passes.hpp"
#include "tests/catch.hpp"
#include "tests/eventually.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using terravox::test::ArrayWorld;
using terravox::test::landscape;

namespace {

constexpr std::size_t kPlenty = std::size_t{256} << 20;

std::vector<voxel::BoxKey> all_keys(const ArrayWorld& world) {
    const auto range = voxel::boxes_over(world.info().bounds, 0);
    std::vector<voxel::BoxKey> out;
    for (int bx = range.min.bx; bx < range.max.bx; ++bx)
        for (int by = range.min.by; by < range.max.by; ++by)
            for (int bz = range.min.bz; bz < range.max.bz; ++bz)
                out.push_back({0, bx, by, bz});
    return out;
}

}  // namespace

TEST_CASE("a box that cannot be loaded is a hole, counted once; the others are there",
          "[raytracer][world]") {
    const auto world = landscape();
    world->make_hole({0, 0, 0, -1});
    blocks::BlockManager blocks(*world, kPlenty);
    const auto range = voxel::boxes_over(world->level_bounds(), 0);
    int holes = 0, boxes = 0;
    for (int round = 0; round < 3; ++round)
        for (int bx = range.min.bx; bx < range.max.bx; ++bx)
            for (int by = range.min.by; by < range.max.by; ++by)
                for (int bz = range.min.bz; bz < range.max.bz; ++bz) {
                    const blocks::BlockPin block = blocks.get({0, bx, by, bz});
                    CHECK(block->hole == (bx == 0 && by == 0 && bz == -1));
                    CHECK_FALSE((block->hole && block->box));
                    holes += block->hole ? 1 : 0;
                    boxes += block->box ? 1 : 0;
                }
    CHECK(blocks.hole_count() == 1);
    CHECK(holes == 3);
    CHECK(boxes > 30);
}

TEST_CASE("a world that has changed is reported by check_world", "[raytracer][world]") {
    const auto world = landscape();
    world->make_hole({0, 0, 0, -1});
    world->make_hole({0, 0, 0, 0}, [] { throw voxel::ChangedError("another one"); });
    blocks::BlockManager blocks(*world, kPlenty);
    CHECK_FALSE(blocks.get({0, 1, 0, 0})->hole);
    CHECK(blocks.get({0, 0, 0, -1})->hole);
    CHECK_NOTHROW(blocks.check_world());
    CHECK(blocks.get({0, 0, 0, 0})->hole);
    CHECK(blocks.is_hole({0, 0, 0, 0}));
    CHECK_THROWS_WITH(blocks.check_world(), "another one");
    blocks.forget_holes();
    CHECK_THROWS_AS(blocks.check_world(), voxel::ChangedError);
}

TEST_CASE("holes are requested again once forgotten, and no sooner", "[raytracer][world]") {
    const std::size_t memory_bytes = GENERATE(kPlenty, std::size_t{1});
    const voxel::BoxKey broken{0, 0, 0, -1}, other{0, 0, 0, 0};
    const auto world = landscape();
    world->make_hole(broken);
    blocks::BlockManager blocks(*world, memory_bytes);
    CHECK(blocks.get(broken)->hole);
    CHECK_FALSE(blocks.get(other)->hole);
    world->mend_hole(broken);
    CHECK(blocks.get(broken)->hole);
    const blocks::BlockPin pinned = blocks.find(broken);
    blocks.forget_holes();
    CHECK(blocks.hole_count() == 0);
    const blocks::BlockPin block = blocks.get(broken);
    CHECK_FALSE(block->hole);
    CHECK(block->box);
    if (pinned)
        CHECK(pinned->hole);  // a pinned block does not change
    CHECK(blocks.get(other)->box);
    CHECK(blocks.stats().bytes <= std::max<std::size_t>(memory_bytes, 64 << 20));
    blocks.forget_holes();
    CHECK(blocks.get(broken)->box);
}

TEST_CASE(
    "a box that was asked for before holes were forgotten, and is a hole by that, is asked for "
    "again",
    "[raytracer][world]") {
    const voxel::BoxKey late{0, 0, 0, -1};
    const auto world = landscape();
    std::atomic<bool> is_asked{false}, may_answer{false};
    world->make_hole(late, [&] {
        if (is_asked.exchange(true))
            return;  // by now it is available
        while (!may_answer)
            std::this_thread::yield();
        throw std::runtime_error("the disk was gone");
    });
    blocks::BlockManager blocks(*world, kPlenty);
    blocks::BlockPin got;
    std::thread waiting([&] { got = blocks.get(late); });
    CHECK(test::eventually([&] { return is_asked.load(); }));
    blocks.forget_holes();
    may_answer = true;
    waiting.join();
    CHECK_FALSE(got->hole);
    CHECK(got->box);
    CHECK(blocks.hole_count() == 0);
    CHECK(world->requests() == 2);
}

TEST_CASE("prefetched boxes are made once, so that a walk requests nothing from the world",
          "[raytracer][world]") {
    const auto world = landscape();
    blocks::BlockManager blocks(*world, kPlenty);
    const auto keys = all_keys(*world);
    blocks.prefetch(keys);
    while (blocks.stats().entries < keys.size())
        std::this_thread::yield();
    CHECK(world->requests() == static_cast<int>(keys.size()));
    for (const auto& key : keys)
        CHECK(blocks.find(key) != nullptr);
    CHECK(world->requests() == static_cast<int>(keys.size()));
}

TEST_CASE("a waiter for a box is notified once, also when the box is in memory already",
          "[raytracer][world]") {
    struct Ear final : blocks::BlockListener {
        bool on_block_loaded(const voxel::BoxKey& key, std::uint64_t ticket) noexcept override {
            heard[key].push_back(ticket);
            ++count;
            return true;
        }
        std::map<voxel::BoxKey, std::vector<std::uint64_t>> heard;  // the manager's lock guards it
        std::atomic<int> count{0};
    };
    const auto world = landscape();
    world->make_hole({0, -1, 0, 0});
    Ear ear;
    blocks::BlockManager blocks(*world, kPlenty);
    for (std::uint64_t i = 0; i < 3; ++i)
        blocks.wait_for({0, 0, 0, 0}, ear, i);
    blocks.wait_for({0, -1, 0, 0}, ear, 7);  // holes are notified, too
    while (ear.count < 4)
        std::this_thread::yield();
    CHECK(blocks.find({0, 0, 0, 0}) != nullptr);
    CHECK(blocks.find({0, -1, 0, 0})->hole);
    blocks.wait_for({0, 0, 0, 0}, ear, 9);
    CHECK(ear.count == 5);
    CHECK(ear.heard[{0, 0, 0, 0}] == std::vector<std::uint64_t>{0, 1, 2, 9});
    CHECK(ear.heard[{0, -1, 0, 0}] == std::vector<std::uint64_t>{7});
    CHECK(world->requests() == 2);
    blocks.forget(ear);
}

TEST_CASE("boxes for a waiter that never reads them do not block others", "[raytracer][world]") {
    struct Ear final : blocks::BlockListener {
        bool on_block_loaded(const voxel::BoxKey&, std::uint64_t) noexcept override {
            ++count;
            return false;
        }
        std::atomic<int> count{0};
    };
    const auto world = landscape();
    Ear ear;
    blocks::BlockManager blocks(*world, 1);  // a single unread box exceeds the limit
    blocks.wait_for({0, 0, 0, 0}, ear, 3);
    CHECK(test::eventually([&] { return ear.count == 1; }));
    blocks.wait_for({0, -1, 0, 0}, ear, 4);
    CHECK(test::eventually([&] { return ear.count == 2; }));
    blocks.wait_for({0, -1, 0, -1}, ear, 6);
    blocks.wait_for({0, 0, 0, -1}, ear, 7);
    blocks.forget(ear, 6);
    CHECK(test::eventually([&] { return ear.count >= 3; }));
    blocks.forget(ear);
}

TEST_CASE("what is in sight of a world of any size is found from coarse to fine",
          "[raytracer][world]") {
    const scene::Camera camera({0, 50, 0}, {100, 40, -80}, 60, 320, 200);
    for (const std::int32_t half : {300, 100'000'000}) {
        const walk::LevelCut cut({{-half, 0, -half}, {half, 200, half}}, 0);
        const auto keys = render::boxes_in_sight(camera, 320, 200, cut, 500);
        CHECK(keys.size() == (half == 300 ? keys.size() : std::size_t{500}));
        REQUIRE(keys.size() > 10);
        CHECK(keys.front().level == 0);
        CHECK(std::abs(keys.front().bx) <= 1);
        CHECK(std::abs(keys.front().bz) <= 1);
        auto sorted = keys;
        std::sort(sorted.begin(), sorted.end());
        CHECK(std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end());
    }
}

TEST_CASE("the limit holds while boxes come and go", "[raytracer][world]") {
    const auto world = landscape();
    const auto keys = all_keys(*world);
    constexpr std::size_t kLimit = 150'000;
    blocks::BlockManager blocks(*world, kLimit);
    for (int round = 0; round < 3; ++round)
        for (const auto& key : keys)
            (void)blocks.get(key);
    CHECK(blocks.stats().levels[0].reloaded > 0);
    CHECK(blocks.stats().peak_bytes <= kLimit + kLimit / 20);
    CHECK(blocks.stats().bytes > kLimit / 2);
}
