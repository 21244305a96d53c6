#include "voxelserver/http/box_replies.hpp"

#include <thread>

#include "common/voxel/box_codec.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/http/fake_world.hpp"

using namespace terravox;

TEST_CASE("a box is made and compressed once, and its frame holds it", "[voxelserver][http]") {
    test::FakeWorld world;
    util::StageTimes times;
    http::BoxReplies replies(world, times, {});
    const voxel::BoxKey key{1, 0, -1, 0};
    const auto first = replies.get(key);
    REQUIRE(first->frame);
    CHECK(replies.get(key) == first);
    CHECK(world.asked == 1);
    const auto box = voxel::decompress_box(std::as_bytes(std::span(*first->frame)), "the reply");
    const auto expected = world.box(key);
    CHECK(std::equal(box->blob().begin(), box->blob().end(), expected->blob().begin(), expected->blob().end()));
}

TEST_CASE("entity tags differ between boxes and are the same for all air", "[voxelserver][http]") {
    test::FakeWorld world;
    util::StageTimes times;
    http::BoxReplies replies(world, times, {});
    const auto a = replies.get({0, 0, 0, 0}), b = replies.get({0, 1, 0, 0}), air = replies.get({0, 0, 1, 0}), outside = replies.get({0, 500, 0, 0});
    CHECK(a->etag != b->etag);
    CHECK(a->etag.front() == '"');
    CHECK(a->etag.back() == '"');
    CHECK_FALSE(air->frame);
    CHECK(air->etag == outside->etag);
}

TEST_CASE("asking for all of space neither asks the world nor fills the cache", "[voxelserver][http]") {
    test::FakeWorld world;
    util::StageTimes times;
    http::BoxReplies replies(world, times, {});
    for (const std::int32_t far : {-2147483647 - 1, -1000, 1000, 2147483647})
        for (int axis = 0; axis < 3; ++axis) {
            const voxel::BoxKey key{0, axis == 0 ? far : 0, axis == 1 ? far : 0, axis == 2 ? far : 0};
            CHECK_FALSE(replies.get(key)->frame);
        }
    CHECK(world.asked == 0);
    CHECK(replies.stats().entries == 0);
}

TEST_CASE("the cache of replies keeps to its limit", "[voxelserver][http]") {
    test::FakeWorld world;
    util::StageTimes times;
    http::BoxReplies replies(world, times, {.memory_bytes = 1000});
    for (int bx = 0; bx < 2; ++bx)
        for (int by = -1; by < 2; ++by) (void)replies.get({0, bx, by, 0});
    CHECK(replies.stats().evictions > 0);
    CHECK(replies.stats().entries <= 2);
}

TEST_CASE("what fails is not remembered", "[voxelserver][http]") {
    test::FakeWorld world;
    world.failing.insert({0, 0, 0, 0});
    util::StageTimes times;
    http::BoxReplies replies(world, times, {});
    CHECK_THROWS_WITH(replies.get({0, 0, 0, 0}), test::contains("damaged"));
    world.failing.clear();
    CHECK(replies.get({0, 0, 0, 0})->frame);
}

TEST_CASE("a gate lets its number in, its line wait, and turns others away", "[voxelserver][http]") {
    http::Gate gate(1, 0);
    {
        const http::Gate::Pass inside(gate);
        CHECK_THROWS_AS(http::Gate::Pass(gate), http::Busy);
    }
    CHECK_NOTHROW(http::Gate::Pass(gate));

    // With room in the line, all get in, never two at once.
    http::Gate queue(1, 8);
    std::atomic<int> inside{0}, most{0}, entered{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < 8; ++i)
        threads.emplace_back([&] {
            for (int n = 0; n < 200; ++n) {
                const http::Gate::Pass pass(queue);
                most = std::max(most.load(), ++inside);
                ++entered;
                --inside;
            }
        });
    for (auto& t : threads) t.join();
    CHECK(most == 1);
    CHECK(entered == 1600);
}
