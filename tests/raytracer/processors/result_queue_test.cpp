#include "raytracer/processors/result_queue.hpp"

#include "tests/catch.hpp"
#include "tests/raytracer/processors/pool_parts.hpp"

using namespace terravox;
using namespace terravox::test;
using processors::ResultQueue;

namespace {

void expect_tiles(ResultQueue& queue, std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i)
        queue.expect(tile_of_rows(i, 8));
}

void push(ResultQueue& queue, std::uint32_t index) {
    tiles::TileResult result;
    result.tile = tile_of_rows(index, 8);
    queue.push(std::move(result));
}

}  // namespace

TEST_CASE("results are taken in the order of their arrival, each once", "[raytracer][sched]") {
    ResultQueue queue;
    expect_tiles(queue, 3);
    CHECK(queue.tiles_left() == 3);
    CHECK_FALSE(queue.can_take(false));
    for (const std::uint32_t index : {2u, 0u, 1u})
        push(queue, index);
    for (const std::uint32_t index : {2u, 0u, 1u}) {
        REQUIRE(queue.can_take(false));
        const tiles::TileResult result = queue.take();
        CHECK(result.tile.index == index);
        CHECK_FALSE(result.again);
    }
    CHECK(queue.tiles_left() == 0);
    CHECK_FALSE(queue.can_take(false));
}

TEST_CASE("the last tile is kept back while a check may invalidate another", "[raytracer][sched]") {
    ResultQueue queue;
    expect_tiles(queue, 2);
    push(queue, 0);
    push(queue, 1);
    CHECK(queue.can_take(true));
    (void)queue.take();
    CHECK_FALSE(queue.can_take(true));
    CHECK(queue.can_take(false));
}

TEST_CASE("a tile that is invalidated before it is taken is not reported", "[raytracer][sched]") {
    ResultQueue queue;
    expect_tiles(queue, 2);
    push(queue, 0);
    queue.invalidate(0);
    CHECK(queue.take_invalidated().empty());
    CHECK(queue.again_left() == 0);
    CHECK_FALSE(queue.can_take(false));
    push(queue, 0);
    CHECK_FALSE(queue.take().again);
    CHECK(queue.tiles_left() == 1);
}

TEST_CASE("a tile that is invalidated after it was taken is returned again, before all others",
          "[raytracer][sched]") {
    ResultQueue queue;
    expect_tiles(queue, 2);
    push(queue, 0);
    (void)queue.take();
    queue.invalidate(0);
    CHECK(queue.take_invalidated() == std::vector<std::uint32_t>{0});
    CHECK(queue.take_invalidated().empty());
    CHECK(queue.again_left() == 1);
    CHECK(queue.tiles_left() == 2);
    push(queue, 1);
    CHECK_FALSE(queue.can_take(false));  // the last one, while another must be returned again
    push(queue, 0);
    REQUIRE(queue.can_take(true));
    const tiles::TileResult again = queue.take();
    CHECK(again.tile.index == 0);
    CHECK(again.again);
    CHECK(queue.again_left() == 0);
    REQUIRE(queue.can_take(false));
    CHECK_FALSE(queue.take().again);
    CHECK(queue.tiles_left() == 0);
}

TEST_CASE("a tile of the next pass is not one that is returned again", "[raytracer][sched]") {
    ResultQueue queue;
    expect_tiles(queue, 1);
    push(queue, 0);
    (void)queue.take();
    CHECK_FALSE(queue.is_merged());
    tiles::RenderTile next = tile_of_rows(0, 8);
    CHECK_FALSE(queue.begins_pass(next));
    SECTION("a finer pass") {
        next.pass = 1;
        CHECK(queue.begins_pass(next));
        queue.expect(next);
        CHECK_FALSE(queue.is_merged());
    }
    SECTION("more samples") {
        next.first_sample = 16;
        CHECK(queue.begins_pass(next));
        queue.expect(next);
        CHECK(queue.is_merged());
    }
    CHECK_FALSE(queue.begins_pass(next));
    push(queue, 0);
    CHECK_FALSE(queue.take().again);
}

TEST_CASE("the queue is full when the caller leaves more than 1024 tiles", "[raytracer][sched]") {
    ResultQueue queue;
    expect_tiles(queue, 1025);
    for (std::uint32_t i = 0; i < 1024; ++i)
        push(queue, i);
    CHECK_FALSE(queue.is_full());
    push(queue, 1024);
    CHECK(queue.is_full());
    (void)queue.take();
    CHECK_FALSE(queue.is_full());
}
