#include "raytracer/processors/thread_processor.hpp"

#include <atomic>
#include <chrono>
#include <functional>
#include <limits>
#include <map>
#include <set>
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

std::vector<tiles::RenderTile> tiles_of(const scene::Scene& scene) {
    const auto [width, height] = scene.output.size_px;
    return tiles::plan_tiles(width, height, 1, scene.quality.tile.in_picture(width),
                             scene.quality.tile_order)
        .front();
}

std::size_t pixels_in(const tiles::RenderTile& tile) {
    std::size_t n = 0;
    tile.each_pixel([&](int, int) { ++n; });
    return n;
}

bool equal(const tiles::TileResult& a, const tiles::TileResult& b) {
    if (a.samples.size() != b.samples.size())
        return false;
    for (std::size_t i = 0; i < a.samples.size(); ++i) {
        const tiles::PixelSample &p = a.samples[i], &q = b.samples[i];
        if (p.colour.r != q.colour.r || p.colour.g != q.colour.g || p.colour.b != q.colour.b ||
            p.alpha != q.alpha || p.depth_m != q.depth_m)
            return false;
    }
    return true;
}

std::map<std::uint32_t, tiles::TileResult> all_results(int threads) {
    Job job(small_scene());
    processors::ThreadProcessor processor(job.view, job.blocks, threads);
    const auto tiles = tiles_of(job.view.scene);
    std::thread submitter([&] {
        for (const tiles::RenderTile& tile : tiles)
            processor.submit(tile);
        processor.close();
    });
    std::map<std::uint32_t, tiles::TileResult> out;
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

/// Delays all boxes until `may_come` is set.
/// @param is_asked called when a box is requested
void hold_back(terravox::test::ArrayWorld& world, const std::atomic<bool>& may_come,
               const std::function<void()>& is_asked) {
    const auto range = voxel::boxes_over(world.info().bounds, 0);
    for (auto key = range.min; key.bx < range.max.bx; ++key.bx)
        for (key.bz = range.min.bz; key.bz < range.max.bz; ++key.bz)
            for (key.by = range.min.by; key.by < range.max.by; ++key.by)
                world.delay(key, [&may_come, is_asked] {
                    is_asked();
                    while (!may_come)
                        std::this_thread::yield();
                });
}

}  // namespace

TEST_CASE("every tile is returned once, the same for any number of threads", "[raytracer][sched]") {
    const auto alone = all_results(1);
    for (const int threads : {2, 5}) {
        const auto several = all_results(threads);
        REQUIRE(several.size() == alone.size());
        for (const auto& [index, result] : alone) {
            INFO(threads << " threads, tile " << index);
            CHECK(equal(result, several.at(index)));
            CHECK(result.counts.rays == several.at(index).counts.rays);
            CHECK(result.counts.all_rays() >= result.samples.size());
        }
    }
}

TEST_CASE("what a tile's task throws reaches take() with its type", "[raytracer][sched]") {
    scene::Scene scene = small_scene();
    scene.camera.inside_rock = true;
    for (const int threads : {1, 3}) {
        Job job(scene);
        processors::ThreadProcessor processor(job.view, job.blocks, threads);
        INFO(threads << " threads");
        // More tiles than fit: a submitter must not wait for ever behind a failure.
        for (int i = 0; i < 40; ++i) {
            tiles::RenderTile tile;  // of more pixels than any vector can hold
            tile.x1 = tile.y1 = std::numeric_limits<std::int32_t>::max() - 1;
            processor.submit(tile);
        }
        CHECK_THROWS_AS(
            [&] {
                while (processor.take()) {
                }
            }(),
            std::length_error);
        CHECK_THROWS_AS(processor.take(), std::length_error);
    }
}

TEST_CASE("a box that throws an error is a hole in the picture and not the end of it",
          "[raytracer][sched]") {
    auto world = landscape();
    world->make_hole({0, 0, 0, 0});
    world->make_hole({0, -1, 0, 0}, [] { throw 42; });
    Job job(small_scene(), std::size_t{256} << 20, std::move(world));
    processors::ThreadProcessor processor(job.view, job.blocks, 2);
    const auto tiles = tiles_of(job.view.scene);
    std::thread submitter([&] {
        for (const tiles::RenderTile& tile : tiles)
            processor.submit(tile);
        processor.close();
    });
    std::uint64_t hole_rays = 0;
    std::size_t taken = 0;
    while (const auto result = processor.take()) {
        hole_rays += result->counts.hole_rays;
        ++taken;
    }
    submitter.join();
    CHECK(taken == tiles.size());
    CHECK(hole_rays > 0);
    CHECK(job.blocks.hole_count() == 2);
}

TEST_CASE("closing finishes the tiles that were accepted", "[raytracer][sched]") {
    Job job(small_scene());
    processors::ThreadProcessor processor(job.view, job.blocks, 2);
    const auto tiles = tiles_of(job.view.scene);
    REQUIRE(tiles.size() > 4);
    for (std::size_t i = 0; i < 4; ++i)
        processor.submit(tiles[i]);
    processor.close();
    processor.close();
    processor.submit(tiles[4]);  // ignored, without waiting
    std::size_t taken = 0;
    while (processor.take())
        ++taken;
    CHECK(taken == 4);
    CHECK_FALSE(processor.take());
}

TEST_CASE("cancelling drops what has not begun, and wakes a submitter that waits for room",
          "[raytracer][sched]") {
    auto world = landscape();
    // The first box waits until the processor is cancelled: until then no tile can end.
    std::atomic<bool> cancelled{false};
    std::atomic<bool> asked{false};
    for (int bx = -2; bx <= 1; ++bx)
        for (int bz = -2; bz <= 1; ++bz)
            world->make_hole({0, bx, 0, bz}, [&] {
                asked = true;
                while (!cancelled)
                    std::this_thread::yield();
                throw std::runtime_error("late");
            });
    scene::Scene scene = small_scene();
    scene.camera.inside_rock = true;
    Job job(scene, std::size_t{256} << 20);
    blocks::BlockManager blocks(*world, std::size_t{256} << 20);
    processors::ThreadProcessor processor(job.view, blocks, 1);
    const auto tiles = tiles_of(scene);
    std::thread submitter([&] {
        for (const tiles::RenderTile& tile : tiles)
            processor.submit(tile);
    });
    while (!asked)
        std::this_thread::yield();
    processor.cancel();
    cancelled = true;
    submitter.join();
    std::size_t taken = 0;
    while (processor.take())
        ++taken;
    CHECK(taken < tiles.size());
}

TEST_CASE("a processor with work waiting can be destroyed", "[raytracer][sched]") {
    Job job(small_scene());
    const auto tiles = tiles_of(job.view.scene);
    for (int round = 0; round < 20; ++round) {
        processors::ThreadProcessor processor(job.view, job.blocks, 1 + round % 3);
        for (std::size_t i = 0; i < 2; ++i)
            processor.submit(tiles[i]);
        if (round % 2 == 0)
            CHECK(processor.take().has_value());
    }
}

TEST_CASE("tiles that wait for a box do not keep a thread from others", "[raytracer][sched]") {
    const auto reference = all_results(1);
    // One box arrives only after several tiles that do not need it have been finished, on a single
    // thread.
    auto world = landscape();
    std::atomic<bool> may_come{false};
    world->delay({0, 0, 0, 0}, [&] {
        while (!may_come)
            std::this_thread::yield();
    });
    scene::Scene scene = small_scene();
    Job job(scene);
    blocks::BlockManager blocks(*world, std::size_t{256} << 20, 2);
    processors::ThreadProcessor processor(job.view, blocks, 1);
    const auto tiles = tiles_of(scene);
    std::thread submitter([&] {
        for (const tiles::RenderTile& tile : tiles)
            processor.submit(tile);
        processor.close();
    });
    std::size_t taken = 0;
    while (const auto result = processor.take()) {
        CHECK(equal(reference.at(result->tile.index), *result));
        if (++taken == 4)
            may_come = true;
    }
    submitter.join();
    CHECK(taken == tiles.size());
}

TEST_CASE("a box that arrives only after its rays were parked repeatedly changes nothing",
          "[raytracer][sched]") {
    // Boxes arrive late and out of order, and are evicted soon: rays are parked thousands of times.
    const auto reference = all_results(1);
    auto world = landscape();
    std::atomic<unsigned> asked{0};
    const auto range = voxel::boxes_over(world->info().bounds, 0);
    for (auto key = range.min; key.bx < range.max.bx; ++key.bx)
        for (key.bz = range.min.bz; key.bz < range.max.bz; ++key.bz)
            for (key.by = range.min.by; key.by < range.max.by; ++key.by)
                world->delay(key, [&asked] {
                    std::this_thread::sleep_for(std::chrono::microseconds(100 * (asked++ % 7)));
                });
    Job job(small_scene());
    blocks::BlockManager blocks(*world, 20'000, 3);
    processors::ThreadProcessor processor(job.view, blocks, 3);
    const auto tiles = tiles_of(job.view.scene);
    std::thread submitter([&] {
        for (const tiles::RenderTile& tile : tiles)
            processor.submit(tile);
        processor.close();
    });
    std::uint64_t parked = 0;
    std::size_t taken = 0;
    while (const auto result = processor.take()) {
        CHECK(equal(reference.at(result->tile.index), *result));
        parked += result->counts.parked;
        ++taken;
    }
    submitter.join();
    CHECK(taken == tiles.size());
    CHECK(parked > tiles.size());
    CHECK(blocks.stats().levels[0].reloaded > 10);
}

TEST_CASE("a stop request takes effect while a world does not answer", "[raytracer][sched]") {
    auto world = landscape();
    std::atomic<bool> released{false};
    std::stop_source stop;
    hold_back(*world, released, [&] { stop.request_stop(); });
    Job job(small_scene());
    blocks::BlockManager blocks(*world, std::size_t{256} << 20);
    output::Film film(job.view.scene.output.size_px[0], job.view.scene.output.size_px[1]);
    {
        processors::ThreadProcessor processor(job.view, blocks, 2);
        CHECK_THROWS_WITH(render::render_film({job.view, processor, true, stop.get_token()}, film),
                          terravox::test::contains("interrupted"));
    }
    released = true;
}

TEST_CASE("a tile that is withdrawn leaves nothing, waiting or begun, and the others are returned",
          "[raytracer][sched]") {
    const auto reference = all_results(1);
    auto world = landscape();
    std::atomic<bool> may_come{false};
    std::atomic<bool> asked{false};
    hold_back(*world, may_come, [&] { asked = true; });
    Job job(small_scene());
    blocks::BlockManager blocks(*world, std::size_t{256} << 20, 2);
    processors::ThreadProcessor processor(job.view, blocks, 1);
    auto tiles = tiles_of(job.view.scene);
    const auto room = static_cast<std::size_t>(processor.capacity());
    tiles.resize(std::min(tiles.size(), room));
    for (const tiles::RenderTile& tile : tiles)
        processor.submit(tile);
    while (!asked)
        std::this_thread::yield();
    // A tile that waits for the box, and tiles that the thread has not begun, or is tracing.
    for (std::size_t i = 0; i < tiles.size(); i += 2)
        processor.withdraw(tiles[i]);
    tiles::RenderTile unknown;
    unknown.index = 10'000;
    processor.withdraw(unknown);
    may_come = true;
    processor.close();
    std::set<std::uint32_t> loaded;
    while (const auto result = processor.take()) {
        CHECK(equal(reference.at(result->tile.index), *result));
        CHECK(loaded.insert(result->tile.index).second);
    }
    for (std::size_t i = 1; i < tiles.size(); i += 2)
        CHECK(loaded.contains(tiles[i].index));
}

TEST_CASE(
    "a tile that is withdrawn while its rays wait for a box is never returned, and may be "
    "submitted "
    "again",
    "[raytracer][sched]") {
    const auto reference = all_results(1);
    auto world = landscape();
    std::atomic<bool> may_come{false};
    std::atomic<bool> asked{false};
    hold_back(*world, may_come, [&] { asked = true; });
    Job job(small_scene());
    blocks::BlockManager blocks(*world, std::size_t{256} << 20, 2);
    const auto tiles = tiles_of(job.view.scene);
    const tiles::RenderTile tile = tiles.front();  // the middle: it sees ground
    {
        processors::ThreadProcessor processor(job.view, blocks, 1);
        processor.submit(tile);
        while (!asked)
            std::this_thread::yield();
        processor.withdraw(tile);
        processor.close();
        CHECK_FALSE(processor.take());  // without the box: else this would wait for ever
    }
    processors::ThreadProcessor processor(job.view, blocks, 1);
    processor.submit(tile);
    processor.withdraw(tile);
    processor.submit(tile);
    may_come = true;
    processor.close();
    const auto result = processor.take();
    REQUIRE(result);
    CHECK(equal(reference.at(tile.index), *result));
    CHECK_FALSE(processor.take());
}
