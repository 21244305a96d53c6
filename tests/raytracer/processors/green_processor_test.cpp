#include "raytracer/processors/green_processor.hpp"

#include <atomic>
#include <chrono>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <thread>

#include "raytracer/tiles/tile_plan.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using namespace std::chrono_literals;
using terravox::test::bytes_of;
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

struct Outcome {
    std::string bytes;
    decltype(tiles::TraceCounts::rays) rays{};
    std::uint64_t parked = 0;
    std::size_t tiles = 0;
};

// All tiles of the picture, with at most capacity() under way; `next` says when a result is there
// to be taken.
template <class Next>
Outcome picture_of(const shade::View& view, processors::TileProcessor& processor,
                   const Next& next) {
    const auto [width, height] = view.scene.output.size_px;
    output::Film film(width, height, view.wants_layers());
    const auto tiles = tiles_of(view.scene);
    Outcome out;
    std::size_t submitted = 0;
    while (out.tiles < tiles.size()) {
        while (submitted < tiles.size() &&
               submitted - out.tiles < static_cast<std::size_t>(processor.capacity()))
            processor.submit(tiles[submitted++]);
        if (submitted == tiles.size())
            processor.close();
        next(processor);
        const auto result = processor.take();
        if (!result)
            break;
        film.add(*result);
        for (std::size_t i = 0; i < out.rays.size(); ++i)
            out.rays[i] += result->counts.rays[i];
        out.parked += result->counts.parked;
        ++out.tiles;
    }
    CHECK_FALSE(processor.take());
    CHECK(out.tiles == tiles.size());
    out.bytes = bytes_of(film);
    return out;
}

scene::Scene scene_named(const std::string& name) {
    scene::Scene scene = small_scene();
    if (name == "path") {
        scene.quality.integrator = core::Integrator::kPath;
        scene.quality.samples = 4;
    }
    if (name == "occlusion") {
        scene.quality.ambient_occlusion = true;
        scene.quality.ao_rays = 4;
    }
    if (name == "layers")
        scene.output.layers = core::PictureLayers::kAll;
    if (name == "large tiles")
        scene.quality.tile = {4096};
    return scene;
}

void wait_patiently(processors::TileProcessor& processor) {
    while (!processor.wait(1h)) {
    }
}

}  // namespace

TEST_CASE("the pixels of one's own stack are those of threads, in whatever slices",
          "[raytracer][sched]") {
    const std::string name =
        GENERATE(as<std::string>(), "direct", "path", "occlusion", "layers", "large tiles");
    INFO(name);
    const scene::Scene scene = scene_named(name);
    Job job(scene);
    processors::ThreadProcessor threads(job.view, job.blocks, 2);
    const Outcome expected = picture_of(job.view, threads, wait_patiently);

    SECTION("taken without waiting") {
        processors::GreenProcessor green(job.view, job.blocks);
        const Outcome got = picture_of(job.view, green, [](processors::TileProcessor&) {});
        CHECK(got.bytes == expected.bytes);
        CHECK(got.rays == expected.rays);
    }
    SECTION("in slices without any time") {
        Job cold(scene);
        processors::GreenProcessor green(cold.view, cold.blocks);
        std::size_t slices = 0;
        const Outcome got = picture_of(cold.view, green, [&](processors::TileProcessor& processor) {
            while (!processor.wait(0ms))
                ++slices;
        });
        CHECK(got.bytes == expected.bytes);
        CHECK(got.rays == expected.rays);
        // Each wave of each tile is a slice of its own, at least.
        CHECK(slices > got.tiles * static_cast<std::size_t>(scene.quality.samples));
    }
}

TEST_CASE("a green processor traces other tiles while one waits for its boxes",
          "[raytracer][sched]") {
    Job reference(small_scene());
    processors::GreenProcessor at_rest(reference.view, reference.blocks);
    const Outcome expected = picture_of(reference.view, at_rest, wait_patiently);

    auto world = landscape();
    std::atomic<bool> may_come{false};
    world->delay({0, 0, 0, 0}, [&] {
        while (!may_come)
            std::this_thread::yield();
    });
    Job job(small_scene());
    blocks::BlockManager blocks(*world, std::size_t{256} << 20, 2);
    processors::GreenProcessor processor(job.view, blocks);
    const auto tiles = tiles_of(job.view.scene);
    std::size_t taken = 0;
    output::Film film(job.view.scene.output.size_px[0], job.view.scene.output.size_px[1]);
    for (const tiles::RenderTile& tile : tiles)
        processor.submit(tile);
    processor.close();
    while (const auto result = processor.take()) {
        film.add(*result);
        if (++taken == 2)
            may_come = true;
    }
    CHECK(taken == tiles.size());
    CHECK(bytes_of(film) == expected.bytes);
}

TEST_CASE(
    "boxes that arrive late, out of order, and are evicted soon change nothing for a green "
    "processor",
    "[raytracer][sched]") {
    Job reference(small_scene());
    processors::GreenProcessor at_rest(reference.view, reference.blocks);
    const Outcome expected = picture_of(reference.view, at_rest, wait_patiently);

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
    processors::GreenProcessor processor(job.view, blocks);
    const Outcome got = picture_of(job.view, processor, [](processors::TileProcessor& p) {
        while (!p.wait(1ms)) {
        }
    });
    CHECK(got.bytes == expected.bytes);
    CHECK(got.parked > got.tiles);
    CHECK(blocks.stats().levels[0].reloaded > 10);
}

TEST_CASE("a slice ends without an answer while a world is silent", "[raytracer][sched]") {
    auto world = landscape();
    std::atomic<bool> released{false};
    std::atomic<bool> asked{false};
    const auto range = voxel::boxes_over(world->info().bounds, 0);
    for (auto key = range.min; key.bx < range.max.bx; ++key.bx)
        for (key.bz = range.min.bz; key.bz < range.max.bz; ++key.bz)
            for (key.by = range.min.by; key.by < range.max.by; ++key.by)
                world->delay(key, [&] {
                    asked = true;
                    while (!released)
                        std::this_thread::yield();
                });
    Job job(small_scene());
    blocks::BlockManager blocks(*world, std::size_t{256} << 20);
    processors::GreenProcessor processor(job.view, blocks);
    for (const tiles::RenderTile& tile : tiles_of(job.view.scene))
        processor.submit(tile);
    while (!asked)
        CHECK_FALSE(processor.wait(0ms));
    for (int i = 0; i < 5; ++i)
        CHECK_FALSE(processor.wait(1ms));
    SECTION("and cancelling is an answer") {
        processor.cancel();
        CHECK(processor.wait(1h));
        CHECK_FALSE(processor.take());
    }
    SECTION("and so is cancelling from elsewhere, while it waits") {
        std::thread other([&] { processor.cancel(); });
        CHECK_FALSE(processor.take());
        other.join();
    }
    SECTION("and the end of the processor is no problem") {}
    released = true;
}

TEST_CASE("cancelling from elsewhere ends a tile that is being traced", "[raytracer][sched]") {
    scene::Scene scene = small_scene();
    scene.quality.samples = std::numeric_limits<int>::max();  // for years
    Job job(scene);
    processors::GreenProcessor processor(job.view, job.blocks);
    processor.submit(tiles_of(scene).front());
    CHECK_FALSE(processor.wait(0ms));
    std::atomic<bool> tracing{false};
    std::thread other([&] {
        while (!tracing)
            std::this_thread::yield();
        processor.cancel();
    });
    tracing = true;
    CHECK_FALSE(processor.take());
    other.join();
}

TEST_CASE("what a tile throws on one's own stack reaches take() with its type",
          "[raytracer][sched]") {
    scene::Scene scene = small_scene();
    scene.camera.inside_rock = true;
    Job job(scene);
    processors::GreenProcessor processor(job.view, job.blocks);
    tiles::RenderTile tile;  // of more pixels than any vector can hold
    tile.x1 = tile.y1 = std::numeric_limits<std::int32_t>::max() - 1;
    processor.submit(tile);
    CHECK(processor.wait(1h));
    CHECK_THROWS_AS(processor.take(), std::length_error);
    CHECK_THROWS_AS(processor.take(), std::length_error);
    processor.submit(tiles_of(scene).front());  // ignored
    CHECK(processor.wait(0ms));
}

TEST_CASE("closing one's own stack finishes what was accepted, and nothing else",
          "[raytracer][sched]") {
    Job job(small_scene());
    processors::GreenProcessor processor(job.view, job.blocks);
    const auto tiles = tiles_of(job.view.scene);
    REQUIRE(tiles.size() > 4);
    CHECK(processor.capacity() >= 1);
    for (std::size_t i = 0; i < 4; ++i)
        processor.submit(tiles[i]);
    processor.close();
    processor.close();
    processor.submit(tiles[4]);
    std::size_t taken = 0;
    while (processor.take())
        ++taken;
    CHECK(taken == 4);
    CHECK_FALSE(processor.take());
    CHECK(processor.wait(1h));
}

TEST_CASE("one thread may submit to another's stack", "[raytracer][sched]") {
    Job job(small_scene());
    processors::GreenProcessor processor(job.view, job.blocks);
    const auto tiles = tiles_of(job.view.scene);
    std::thread submitter([&] {
        for (const tiles::RenderTile& tile : tiles)
            processor.submit(tile);
        processor.close();
    });
    std::size_t taken = 0;
    while (processor.take())
        ++taken;
    submitter.join();
    CHECK(taken == tiles.size());
}

TEST_CASE("a tile withdrawn in the middle leaves no result on one's own stack",
          "[raytracer][sched]") {
    Job job(small_scene());
    const auto tiles = tiles_of(job.view.scene);
    processors::GreenProcessor processor(job.view, job.blocks);
    processor.submit(tiles[0]);
    processor.submit(tiles[1]);
    (void)processor.wait(0ms);  // the first has begun
    processor.withdraw(tiles[0]);
    processor.close();
    const auto result = processor.take();
    REQUIRE(result);
    CHECK(result->tile == tiles[1]);
    CHECK_FALSE(processor.take());
}
