#include "raytracer/sched/thread_processor.hpp"

#include <atomic>
#include <map>
#include <new>
#include <stdexcept>
#include <thread>

#include "raytracer/tiles/tile_plan.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using terravox::test::Job;
using terravox::test::landscape;
using terravox::test::small_scene;

namespace {

/// Not an std::exception: nothing on the way may take it for a missing box.
struct Stop {
    int code;
};

std::vector<RenderTile> tiles_of(const Scene& scene) {
    return plan_tiles(scene.output.size_px[0], scene.output.size_px[1], 1, scene.quality.tile_px, scene.quality.tile_order).front();
}

std::size_t pixels_in(const RenderTile& tile) {
    std::size_t n = 0;
    tile.each_pixel([&](int, int) { ++n; });
    return n;
}

bool equal(const TileResult& a, const TileResult& b) {
    if (a.samples.size() != b.samples.size()) return false;
    for (std::size_t i = 0; i < a.samples.size(); ++i) {
        const PixelSample &p = a.samples[i], &q = b.samples[i];
        if (p.colour.r != q.colour.r || p.colour.g != q.colour.g || p.colour.b != q.colour.b || p.alpha != q.alpha || p.depth_m != q.depth_m) return false;
    }
    return true;
}

std::map<std::uint32_t, TileResult> all_results(int threads) {
    Job job(small_scene());
    ThreadProcessor processor(job.view, job.blocks, threads);
    const auto tiles = tiles_of(job.view.scene);
    std::thread submitter([&] {
        for (const RenderTile& tile : tiles) processor.submit(tile);
        processor.close();
    });
    std::map<std::uint32_t, TileResult> out;
    while (auto result = processor.take()) {
        INFO("tile " << result->tile.index);
        CHECK(result->samples.size() == pixels_in(result->tile));
        const auto index = result->tile.index;
        CHECK(out.emplace(index, std::move(*result)).second);
    }
    submitter.join();
    CHECK(out.size() == tiles.size());
    return out;
}

}  // namespace

TEST_CASE("every tile comes back once, the same for any number of threads", "[raytracer][sched]") {
    const auto alone = all_results(1);
    for (const int threads : {2, 5}) {
        const auto several = all_results(threads);
        REQUIRE(several.size() == alone.size());
        for (const auto& [index, result] : alone) {
            INFO(threads << " threads, tile " << index);
            CHECK(equal(result, several.at(index)));
            CHECK(result.rays == several.at(index).rays);
            CHECK(result.rays >= result.samples.size());
        }
    }
}

TEST_CASE("what a tile's task throws reaches take() with its type", "[raytracer][sched]") {
    auto world = landscape();
    for (int bx = -2; bx <= 1; ++bx)
        for (int bz = -2; bz <= 1; ++bz)
            for (int by = -1; by <= 0; ++by) world->make_hole({0, bx, by, bz}, [] { throw Stop{42}; });
    Scene scene = small_scene();
    scene.camera.inside_rock = true;
    for (const int threads : {1, 3}) {
        Job job(scene, std::size_t{256} << 20, landscape());
        BlockManager blocks(*world, std::size_t{256} << 20);
        ThreadProcessor processor(job.view, blocks, threads);
        INFO(threads << " threads");
        // More tiles than fit: a submitter must not wait for ever behind a failure.
        for (const RenderTile& tile : tiles_of(scene)) processor.submit(tile);
        int code = 0;
        try {
            while (processor.take()) {}
        } catch (const Stop& stop) {
            code = stop.code;
        }
        CHECK(code == 42);
        CHECK_THROWS_AS(processor.take(), Stop);
    }
}

TEST_CASE("a box that throws an error is a hole in the picture and not the end of it", "[raytracer][sched]") {
    auto world = landscape();
    world->make_hole({0, 0, 0, 0});
    world->make_hole({0, -1, 0, 0}, [] { throw std::bad_alloc(); });
    Job job(small_scene(), std::size_t{256} << 20, std::move(world));
    ThreadProcessor processor(job.view, job.blocks, 2);
    const auto tiles = tiles_of(job.view.scene);
    std::thread submitter([&] {
        for (const RenderTile& tile : tiles) processor.submit(tile);
        processor.close();
    });
    std::uint64_t hole_rays = 0;
    std::size_t taken = 0;
    while (const auto result = processor.take()) hole_rays += result->hole_rays, ++taken;
    submitter.join();
    CHECK(taken == tiles.size());
    CHECK(hole_rays > 0);
    CHECK(job.blocks.hole_count() == 2);
}

TEST_CASE("closing finishes the tiles that were accepted", "[raytracer][sched]") {
    Job job(small_scene());
    ThreadProcessor processor(job.view, job.blocks, 2);
    const auto tiles = tiles_of(job.view.scene);
    REQUIRE(tiles.size() > 4);
    for (std::size_t i = 0; i < 4; ++i) processor.submit(tiles[i]);
    processor.close();
    processor.close();
    processor.submit(tiles[4]);  // ignored, without waiting
    std::size_t taken = 0;
    while (processor.take()) ++taken;
    CHECK(taken == 4);
    CHECK_FALSE(processor.take());
}

TEST_CASE("cancelling drops what has not begun, and wakes a submitter that waits for room", "[raytracer][sched]") {
    auto world = landscape();
    // The first box waits until the processor is cancelled: until then no tile can end.
    std::atomic<bool> cancelled{false}, asked{false};
    for (int bx = -2; bx <= 1; ++bx)
        for (int bz = -2; bz <= 1; ++bz)
            world->make_hole({0, bx, 0, bz}, [&] {
                asked = true;
                while (!cancelled) std::this_thread::yield();
                throw std::runtime_error("late");
            });
    Scene scene = small_scene();
    scene.camera.inside_rock = true;
    Job job(scene, std::size_t{256} << 20);
    BlockManager blocks(*world, std::size_t{256} << 20);
    ThreadProcessor processor(job.view, blocks, 1);
    const auto tiles = tiles_of(scene);
    std::thread submitter([&] {
        for (const RenderTile& tile : tiles) processor.submit(tile);
    });
    while (!asked) std::this_thread::yield();
    processor.cancel();
    cancelled = true;
    submitter.join();
    std::size_t taken = 0;
    while (processor.take()) ++taken;
    CHECK(taken < tiles.size());
}

TEST_CASE("a processor with work waiting can be destroyed", "[raytracer][sched]") {
    Job job(small_scene());
    const auto tiles = tiles_of(job.view.scene);
    for (int round = 0; round < 20; ++round) {
        ThreadProcessor processor(job.view, job.blocks, 1 + round % 3);
        for (std::size_t i = 0; i < 2; ++i) processor.submit(tiles[i]);
        if (round % 2 == 0) CHECK(processor.take().has_value());
    }
}
