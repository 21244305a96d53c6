#include "voxelserver/serve/boxes/box_cache.hpp"

#include <algorithm>
#include <cstdint>
#include <thread>
#include <vector>

#include "common/voxel/box.hpp"
#include "tests/catch.hpp"
#include "tests/common/small_stack.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/serve/http/fake_world.hpp"
#include "voxelserver/serve/boxes/preparer.hpp"

using namespace terravox;
using boxes::BoxCache;
using boxes::BoxCacheOptions;
using boxes::PrefetchQueue;
using voxel::BoxKey;

namespace {

struct Fixture {
    explicit Fixture(BoxCacheOptions options = {.ahead = false}) : cache(world, times, options) {}
    test::FakeWorld world;
    util::StageTimes times;
    BoxCache cache;
};

}  // namespace

TEST_CASE("a box is made and compressed once, and its frame holds it", "[voxelserver][boxes]") {
    Fixture f;
    const BoxKey key{0, 0, -1, 0};
    const auto first = f.cache.find_or_make(key);
    REQUIRE_FALSE(first->air());
    CHECK(f.cache.find_or_make(key) == first);
    CHECK(f.world.requests == 1);
    const auto expected = f.world.box(key), box = BoxCache::decompress(*first, key);
    CHECK(std::equal(box->blob().begin(), box->blob().end(), expected->blob().begin(),
                     expected->blob().end()));
    CHECK(first->checksum == expected->checksum());
}

TEST_CASE("boxes are made with a stack of their own, whatever the caller's",
          "[voxelserver][boxes]") {
    Fixture f;
    f.world.stack_bytes = 10 * test::kSmallStack_bytes;
    boxes::CompressedBoxPtr fine;
    boxes::CompressedBoxPtr coarse;
    test::on_small_stack([&] {
        fine = f.cache.find_or_make({0, 0, -1, 0});
        coarse = f.cache.find_or_make({2, 0, -1, 0});
    });
    REQUIRE((fine && coarse));
    CHECK_FALSE(fine->air());
    CHECK_FALSE(coarse->air());
}

TEST_CASE("a box above level 0 is the world's own, made of children that are kept",
          "[voxelserver][boxes]") {
    Fixture f;
    const BoxKey key{2, 0, -1, 0};
    const auto kept = f.cache.find_or_make(key);
    const int requests = f.world.requests;
    const auto expected = f.world.box(key), box = BoxCache::decompress(*kept, key);
    CHECK(std::equal(box->blob().begin(), box->blob().end(), expected->blob().begin(),
                     expected->blob().end()));
    // The reach of all of its children, and its own ground.
    CHECK(kept->reach.min_bx <= 0);
    CHECK(kept->reach.max_bx >= 4);
    f.world.requests = 0;
    (void)f.cache.find_or_make({1, 0, -1, 0});
    (void)f.cache.find_or_make({0, 1, -1, 0});
    CHECK(f.world.requests == 0);
    CHECK(requests > 0);
}

TEST_CASE("a world that makes all levels is requested for a coarse box itself",
          "[voxelserver][boxes]") {
    /// Its coarse boxes are not its fine ones, downsampled.
    class OwnLevels final : public voxel::ProvenanceWorld {
    public:
        [[nodiscard]] const voxel::WorldInfo& info() const noexcept override {
            return m_fake.info();
        }
        [[nodiscard]] std::shared_ptr<const voxel::Box> box(const BoxKey& key) override {
            requested.push_back(key);
            return m_fake.box({key.level, key.bx, key.by, key.bz});
        }
        [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx,
                                                 std::int32_t bz) override {
            return m_fake.column(level, bx, bz);
        }
        [[nodiscard]] voxel::BoxWithInputs box_with_inputs(const BoxKey& key) override {
            return {box(key), {}};
        }
        [[nodiscard]] voxel::Fingerprint fingerprint(const voxel::InputExtent&) const override {
            return {1, 2};
        }
        std::vector<BoxKey> requested;

    private:
        test::FakeWorld m_fake;
    } world;
    util::StageTimes times;
    BoxCache cache(world, times, {.downsample = false, .ahead = false});
    const BoxKey key{2, 0, -1, 0};
    (void)cache.find_or_make(key);
    REQUIRE(cache.find_or_make_when_idle({1, 0, -1, 0}) != nullptr);
    CHECK(world.requested == std::vector<BoxKey>{key, {1, 0, -1, 0}});
}

TEST_CASE("requests for all of space neither reach the world nor fill the cache",
          "[voxelserver][boxes]") {
    Fixture f;
    for (const std::int32_t far : {-2147483647 - 1, -1000, 1000, 2147483647})
        for (int axis = 0; axis < 3; ++axis)
            for (int level = 0; level < 3; ++level)
                CHECK(f.cache
                          .find_or_make({level, axis == 0 ? far : 0, axis == 1 ? far : 0,
                                         axis == 2 ? far : 0})
                          ->air());
    CHECK(f.world.requests == 0);
    CHECK(f.cache.stats().memory.entries == 0);
}

TEST_CASE("memory keeps to its limit, and what fails is not remembered", "[voxelserver][boxes]") {
    Fixture f({.memory_bytes = 1000, .ahead = false});
    for (int bx = 0; bx < 2; ++bx)
        for (int by = -1; by < 2; ++by)
            (void)f.cache.find_or_make({0, bx, by, 0});
    CHECK(f.cache.stats().memory.evictions > 0);
    CHECK(f.cache.stats().memory.entries <= 2);
    f.world.failing.insert({0, 0, 0, 0});
    CHECK_THROWS_WITH(f.cache.find_or_make({0, 0, 0, 0}), test::contains("damaged"));
    CHECK(f.cache.stats().failed == 1);
    f.world.failing.clear();
    CHECK_FALSE(f.cache.find_or_make({0, 0, 0, 0})->air());
}

TEST_CASE("a second process takes from disk what still holds, and makes the rest again",
          "[voxelserver][boxes]") {
    const test::TemporaryFolder folder;
    const BoxCacheOptions options{.ahead = false, .file = folder.path() / "boxes.sqlite"};
    std::vector<BoxKey> keys;
    for (int bx = 0; bx < 2; ++bx)
        for (int by = -1; by < 2; ++by)
            keys.push_back({0, bx, by, 0});
    std::vector<std::string> frames;
    {
        Fixture f(options);
        for (const BoxKey& key : keys) {
            const auto kept = f.cache.find_or_make(key);
            frames.push_back(kept->air() ? "" : *kept->frame);
        }
    }
    {
        Fixture f(options);
        for (std::size_t i = 0; i < keys.size(); ++i) {
            const auto kept = f.cache.find_or_make(keys[i]);
            CHECK((kept->air() ? "" : *kept->frame) == frames[i]);
        }
        CHECK(f.world.requests == 0);
        CHECK(f.cache.stats().made == 0);
    }
    Fixture f(options);
    f.world.versions[{2, 0}] = 1;  // boxes of column 1 reach it, those of column 0 do not
    for (const BoxKey& key : keys)
        (void)f.cache.find_or_make(key);
    CHECK(f.world.requests == 3);
}

TEST_CASE(
    "neighbours of a box that had to be made, and those above and below it, are made ahead, and "
    "only those",
    "[voxelserver][boxes]") {
    Fixture f({.makers = 2, .ahead = true});
    (void)f.cache.find_or_make({0, 0, 0, 0});
    const auto done = [&] {
        const auto s = f.cache.stats();
        // (0,0) with those above and below, (1,0), (0,-1), (1,-1)
        return s.made == 6 && s.ahead_waiting == 0 && s.admission.ahead_running == 0;
    };
    while (!done())
        std::this_thread::yield();
    CHECK(f.cache.stats().made_ahead == 5);
    CHECK(f.world.requests == 6);
    (void)f.cache.find_or_make({0, 1, 0, -1});
    (void)f.cache.find_or_make({0, 0, -1, 0});
    CHECK(f.world.requests == 6);
}

TEST_CASE("a listener is called for every box that becomes available, when it can be found",
          "[voxelserver][boxes]") {
    Fixture f;
    std::vector<BoxKey> heard;
    f.cache.set_listener([&](const BoxKey& key) {
        CHECK(f.cache.find(key));
        heard.push_back(key);
    });
    (void)f.cache.find_or_make({1, 0, -1, 0});
    (void)f.cache.find_or_make({1, 0, -1, 0});
    CHECK(heard.size() == 3);  // itself and two children: the other six lie outside the world
    CHECK(heard.back() == BoxKey{1, 0, -1, 0});
}

TEST_CASE("preparing makes every box of the world, children first, and counts what fails",
          "[voxelserver][boxes]") {
    const int lanes = GENERATE(1, 3);
    Fixture f({.makers = 2, .ahead = false});
    f.world.failing.insert({0, 1, 0, -1});
    std::vector<std::string> failures;
    {
        boxes::Preparer preparer(f.cache, lanes,
                                 [&](const std::string& why) { failures.push_back(why); });
        while (!preparer.finished())
            std::this_thread::yield();
        const auto p = preparer.progress();
        CHECK(p.done == p.total);
        // Level 0; levels 1 and 2, each two boxes high, and two wide from north to south.
        CHECK(p.total == 2 * 3 * 2 + 4 + 4);
        CHECK(p.failed == failures.size());
        CHECK(p.failed >= 3);  // the box, and those above it
    }
    f.world.failing.clear();
    f.world.requests = 0;
    const auto range = voxel::boxes_over(f.world.info().bounds, 0);
    for (auto bx = range.min.bx; bx < range.max.bx; ++bx)
        for (auto by = range.min.by; by < range.max.by; ++by)
            for (auto bz = range.min.bz; bz < range.max.bz; ++bz)
                (void)f.cache.find_or_make({0, bx, by, bz});
    CHECK(f.world.requests == 1);
}

TEST_CASE("all boxes of a world are walked once, each after its children", "[voxelserver][boxes]") {
    test::FakeWorld world;
    boxes::BoxTraversal walk(world);
    std::set<BoxKey> seen;
    BoxKey key;
    while (walk.next(key)) {
        CHECK(seen.insert(key).second);
        if (key.level == 0)
            continue;
        for (int i = 0; i < 8; ++i) {
            const BoxKey child{key.level - 1, 2 * key.bx + (i & 1), 2 * key.by + (i >> 2),
                               2 * key.bz + (i >> 1 & 1)};
            if (voxel::boxes_over(world.info().bounds, child.level).contains(child))
                CHECK(seen.contains(child));
        }
    }
    CHECK(seen.size() == boxes::BoxTraversal::count(world));
}

TEST_CASE("no more callers wait for boxes than have places, and what is kept needs none",
          "[voxelserver][boxes]") {
    Fixture f({.makers = 1, .max_requests = 2, .ahead = false});
    (void)f.cache.find_or_make({0, 1, 0, 0});
    f.world.hold();
    std::vector<std::thread> waiting;
    for (int i = 0; i < 2; ++i)
        waiting.emplace_back([&] { CHECK_FALSE(f.cache.find_or_make({0, 0, 0, 0})->air()); });
    while (f.cache.stats().memory.waits == 0)
        std::this_thread::yield();
    CHECK_THROWS_AS(f.cache.find_or_make({0, 0, 0, 0}), boxes::OverloadedError);
    CHECK_FALSE(f.cache.find_or_make({0, 1, 0, 0})->air());
    f.world.release();
    for (auto& t : waiting)
        t.join();
    CHECK_FALSE(f.cache.find_or_make({0, 0, 0, 0})->air());
}

TEST_CASE("a box of many children stops at the next one when the cache refuses",
          "[voxelserver][boxes]") {
    Fixture f({.makers = 1, .ahead = false});
    f.world.hold();
    std::thread request(
        [&] { CHECK_THROWS_AS(f.cache.find_or_make({2, 0, -1, 0}), boxes::OverloadedError); });
    while (f.world.requests == 0)
        std::this_thread::yield();
    f.cache.refuse();
    f.world.release();
    request.join();
    CHECK(f.world.requests == 1);
}

namespace {

BoxKey box(std::int32_t bx) {
    return {0, bx, 0, 0};
}

bool all(const BoxKey&) {
    return true;
}

std::vector<BoxKey> take_all(PrefetchQueue& queue) {
    std::vector<BoxKey> out;
    while (queue.size() > 0)
        out.push_back(queue.take().value());
    return out;
}

}  // namespace

TEST_CASE("the wanted key that was added last is prefetched first, and each is queued once",
          "[voxelserver][boxes]") {
    PrefetchQueue queue(10);
    queue.add({box(1), box(2), box(1)}, all);
    queue.add({box(1)}, all);
    queue.add({box(3), box(4)}, [](const BoxKey& key) { return key != box(3); });
    CHECK(queue.size() == 3);
    CHECK(take_all(queue) == std::vector<BoxKey>{box(4), box(2), box(1)});
    queue.add({box(1)}, all);
    CHECK(take_all(queue) == std::vector<BoxKey>{box(1)});
}

TEST_CASE("a full prefetch queue drops its oldest keys, which can then be added again",
          "[voxelserver][boxes]") {
    PrefetchQueue queue(2);
    queue.add({box(1), box(2), box(3)}, all);
    CHECK(queue.size() == 2);
    queue.add({box(1)}, all);
    CHECK(take_all(queue) == std::vector<BoxKey>{box(1), box(3)});
}

TEST_CASE("a closed prefetch queue yields no keys and accepts none", "[voxelserver][boxes]") {
    PrefetchQueue queue(10);
    queue.add({box(1)}, all);
    queue.close();
    queue.close();
    queue.add({box(2)}, all);
    CHECK(queue.size() == 1);
    CHECK_FALSE(queue.take().has_value());
}

TEST_CASE("adding a key, and closing, end the wait for a key to prefetch", "[voxelserver][boxes]") {
    PrefetchQueue queue(10);
    std::vector<BoxKey> taken;
    std::thread taking([&] {
        while (const auto key = queue.take())
            taken.push_back(*key);
    });
    queue.add({box(1)}, all);
    while (queue.size() > 0)
        std::this_thread::yield();
    queue.close();
    taking.join();
    CHECK(taken == std::vector<BoxKey>{box(1)});
}
