// What threads and one's own stack have in common as processors of tiles, and what each has alone.

#include <atomic>
#include <chrono>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <stop_token>
#include <thread>

#include "raytracer/core/tiles/tile_codec.hpp"
#include "raytracer/core/tiles/tile_plan.hpp"
#include "raytracer/farm/processors/green_processor.hpp"
#include "raytracer/farm/processors/thread_processor.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using namespace std::chrono_literals;
using terravox::test::Job;
using terravox::test::landscape;
using terravox::test::small_scene;
using terravox::test::to_bytes;

namespace {

constexpr std::size_t kMemory_bytes = std::size_t{256} << 20;
constexpr int kGreen = 0;  // instead of a number of threads

std::unique_ptr<processors::TileProcessor> make_processor(int threads, const shade::View& view,
                                                          blocks::BlockManager& blocks) {
    if (threads == kGreen)
        return std::make_unique<processors::GreenProcessor>(view, blocks);
    return std::make_unique<processors::ThreadProcessor>(view, blocks, threads);
}

std::vector<tiles::RenderTile> list_tiles(const scene::Scene& scene) {
    const auto [width, height] = scene.output.size_px;
    return tiles::plan_tiles(width, height, 1, scene.quality.tile.in_picture(width),
                             scene.quality.tile_order)
        .front();
}

/// What a processor returns for all tiles of a picture.
struct Outcome {
    std::string bytes;
    std::map<std::uint32_t, tiles::TileResult> tiles;
    std::uint64_t parked = 0;
    std::uint64_t hole_rays = 0;
};

/// Submits all tiles from another thread, as a processor of threads waits for room.
/// @param before_take is called before each result, with the number of those that were taken
Outcome render_picture(
    const shade::View& view, processors::TileProcessor& processor,
    const std::function<void(std::size_t)>& before_take = [](std::size_t) {}) {
    const auto tiles = list_tiles(view.scene);
    std::thread submitter([&] {
        for (const tiles::RenderTile& tile : tiles)
            processor.submit(tile);
        processor.close();
    });
    const auto [width, height] = view.scene.output.size_px;
    output::Film film(width, height, view.wants_layers());
    Outcome out;
    before_take(0);
    while (auto result = processor.take()) {
        film.add(*result);
        out.parked += result->counts.parked;
        out.hole_rays += result->counts.hole_rays;
        const auto index = result->tile.index;
        CHECK(out.tiles.emplace(index, std::move(*result)).second);
        before_take(out.tiles.size());
    }
    submitter.join();
    CHECK_FALSE(processor.take());
    CHECK(out.tiles.size() == tiles.size());
    out.bytes = to_bytes(film);
    return out;
}

/// What a processor with plenty of memory and time returns.
Outcome make_expected(const scene::Scene& scene) {
    Job job(scene);
    processors::ThreadProcessor processor(job.view, job.blocks, 1);
    return render_picture(job.view, processor);
}

bool equal(const tiles::TileResult& a, const tiles::TileResult& b) {
    return tiles::hash_of_pixels(a) == tiles::hash_of_pixels(b);
}

void delay_all(terravox::test::ArrayWorld& world, const std::function<void()>& before) {
    const auto range = voxel::boxes_over(world.info().bounds, 0);
    for (auto key = range.min; key.bx < range.max.bx; ++key.bx)
        for (key.bz = range.min.bz; key.bz < range.max.bz; ++key.bz)
            for (key.by = range.min.by; key.by < range.max.by; ++key.by)
                world.delay(key, before);
}

/// A processor of a world none of whose boxes comes before it is released.
struct Silent {
    explicit Silent(
        int threads, std::function<void()> is_asked = [] {})
        : job(small_scene()),
          blocks(*world, kMemory_bytes, 2),
          processor(make_processor(threads, job.view, blocks)) {
        delay_all(*world, [this, is_asked = std::move(is_asked)] {
            asked = true;
            is_asked();
            while (!released)
                std::this_thread::yield();
        });
    }
    /// Loaders must end before the world does, even where a check has failed.
    ~Silent() { released = true; }
    void wait_until_asked() {
        while (!asked)
            (void)processor->wait(0ms);  // one's own stack works only meanwhile
    }
    std::unique_ptr<terravox::test::ArrayWorld> world = landscape();
    std::atomic<bool> asked{false}, released{false};
    Job job;
    blocks::BlockManager blocks;
    std::unique_ptr<processors::TileProcessor> processor;
};

}  // namespace

TEST_CASE("every tile is returned once, the same by any processor, in whatever slices",
          "[raytracer][sched]") {
    const std::string name =
        GENERATE(as<std::string>(), "direct", "path", "occlusion", "layers", "large tiles");
    INFO(name);
    scene::Scene scene = small_scene();
    if (name == "path") {
        scene.quality.integrator = core::Integrator::kPath;
        scene.quality.samples = 4;
    }
    if (name == "occlusion")
        scene.quality.ao_rays = 4;
    if (name == "layers")
        scene.output.layers = core::PictureLayers::kAll;
    if (name == "large tiles")
        scene.quality.tile = {4096};
    const Outcome expected = make_expected(scene);
    const auto check = [&](const Outcome& got) {
        CHECK(got.bytes == expected.bytes);
        for (const auto& [index, tile] : expected.tiles)
            CHECK(got.tiles.at(index).counts.rays == tile.counts.rays);
    };
    for (const int threads : {5, kGreen}) {
        INFO(threads << " threads");
        Job job(scene);
        check(render_picture(job.view, *make_processor(threads, job.view, job.blocks)));
    }
    Job cold(scene);
    processors::GreenProcessor green(cold.view, cold.blocks);
    std::size_t slices = 0;
    const Outcome sliced = render_picture(cold.view, green, [&](std::size_t) {
        while (!green.wait(0ms))
            ++slices;
    });
    check(sliced);
    // Each wave of each tile is a slice of its own, at least.
    CHECK(slices > sliced.tiles.size() * static_cast<std::size_t>(scene.quality.samples));
}

TEST_CASE("what a tile throws reaches take() with its type", "[raytracer][sched]") {
    const int threads = GENERATE(1, 3, kGreen);
    INFO(threads << " threads");
    Job job(small_scene());
    const auto processor = make_processor(threads, job.view, job.blocks);
    // More tiles than fit: a submitter must not wait for ever behind a failure.
    for (int i = 0; i < 40; ++i) {
        tiles::RenderTile tile;  // of more pixels than any vector can hold
        tile.x1 = tile.y1 = std::numeric_limits<std::int32_t>::max() - 1;
        processor->submit(tile);
    }
    CHECK_THROWS_AS(
        [&] {
            while (processor->take()) {
            }
        }(),
        std::length_error);
    CHECK_THROWS_AS(processor->take(), std::length_error);
    CHECK(processor->wait(0ms));
}

TEST_CASE("a box that throws an error is a hole in the picture and not the end of it",
          "[raytracer][sched]") {
    const int threads = GENERATE(2, kGreen);
    auto world = landscape();
    world->make_hole({0, 0, 0, 0});
    world->make_hole({0, -1, 0, 0}, [] { throw 42; });
    Job job(small_scene(), kMemory_bytes, std::move(world));
    CHECK(render_picture(job.view, *make_processor(threads, job.view, job.blocks)).hole_rays > 0);
    CHECK(job.blocks.hole_count() == 2);
}

TEST_CASE("closing finishes the tiles that were accepted, and nothing else", "[raytracer][sched]") {
    const int threads = GENERATE(2, kGreen);
    Job job(small_scene());
    const auto processor = make_processor(threads, job.view, job.blocks);
    const auto tiles = list_tiles(job.view.scene);
    for (std::size_t i = 0; i < 4; ++i)
        processor->submit(tiles.at(i));
    processor->close();
    processor->close();
    processor->submit(tiles.at(4));  // ignored, without waiting
    std::size_t taken = 0;
    while (processor->take())
        ++taken;
    CHECK(taken == 4);
    CHECK_FALSE(processor->take());
    CHECK(processor->wait(1h));
}

TEST_CASE("tiles that wait for a box do not keep others from being traced", "[raytracer][sched]") {
    const int threads = GENERATE(1, kGreen);
    // One box arrives only after some tiles that do not need it have been finished.
    auto world = landscape();
    std::atomic<bool> may_come{false};
    world->delay({0, 0, 0, 0}, [&] {
        while (!may_come)
            std::this_thread::yield();
    });
    Job job(small_scene());
    blocks::BlockManager blocks(*world, kMemory_bytes, 2);
    const Outcome got = render_picture(job.view, *make_processor(threads, job.view, blocks),
                                       [&](std::size_t taken) {
                                           if (taken == 2)
                                               may_come = true;
                                       });
    CHECK(got.bytes == make_expected(job.view.scene).bytes);
}

TEST_CASE("boxes that arrive late, out of order, and are evicted soon change nothing",
          "[raytracer][sched]") {
    const int threads = GENERATE(3, kGreen);
    auto world = landscape();
    std::atomic<unsigned> asked{0};
    delay_all(*world, [&asked] {
        std::this_thread::sleep_for(std::chrono::microseconds(100 * (asked++ % 7)));
    });
    Job job(small_scene());
    blocks::BlockManager blocks(*world, 20'000, 3);
    const Outcome got = render_picture(job.view, *make_processor(threads, job.view, blocks));
    CHECK(got.bytes == make_expected(job.view.scene).bytes);
    CHECK(got.parked > got.tiles.size());
    CHECK(blocks.stats().levels[0].reloaded > 10);
}

TEST_CASE("a stop request takes effect while a world does not answer", "[raytracer][sched]") {
    const int threads = GENERATE(2, kGreen);
    std::stop_source stop;
    Silent silent(threads, [&] { stop.request_stop(); });
    const auto [width, height] = silent.job.view.scene.output.size_px;
    output::Film film(width, height);
    CHECK_THROWS_WITH(
        render::render_film({silent.job.view, *silent.processor, true, stop.get_token()}, film),
        terravox::test::contains("interrupted"));
}

TEST_CASE("a tile that is withdrawn leaves nothing, waiting or begun, and the others are returned",
          "[raytracer][sched]") {
    const int threads = GENERATE(1, kGreen);
    const Outcome expected = make_expected(small_scene());
    Silent silent(threads);
    auto tiles = list_tiles(silent.job.view.scene);
    const auto room = static_cast<std::size_t>(silent.processor->capacity());
    tiles.resize(std::min(tiles.size(), room));
    for (const tiles::RenderTile& tile : tiles)
        silent.processor->submit(tile);
    silent.wait_until_asked();
    // A tile that waits for the box, and tiles that have not begun, or are being traced.
    for (std::size_t i = 0; i < tiles.size(); i += 2)
        silent.processor->withdraw(tiles[i]);
    tiles::RenderTile unknown;
    unknown.index = 10'000;
    silent.processor->withdraw(unknown);
    silent.released = true;
    silent.processor->close();
    std::set<std::uint32_t> loaded;
    while (const auto result = silent.processor->take()) {
        CHECK(equal(expected.tiles.at(result->tile.index), *result));
        CHECK(loaded.insert(result->tile.index).second);
    }
    for (std::size_t i = 1; i < tiles.size(); i += 2)
        CHECK(loaded.contains(tiles[i].index));
}

TEST_CASE("a tile whose rays wait for a box may be withdrawn, and submitted again",
          "[raytracer][sched]") {
    const int threads = GENERATE(1, kGreen);
    Silent silent(threads);
    const tiles::RenderTile tile =
        list_tiles(silent.job.view.scene).front();  // the middle: it sees ground
    silent.processor->submit(tile);
    silent.wait_until_asked();
    silent.processor->withdraw(tile);
    silent.processor->close();
    CHECK_FALSE(silent.processor->take());  // without the box: else this would wait for ever
    silent.processor = make_processor(threads, silent.job.view, silent.blocks);
    silent.processor->submit(tile);
    silent.processor->withdraw(tile);
    silent.processor->submit(tile);
    silent.released = true;
    silent.processor->close();
    const auto result = silent.processor->take();
    REQUIRE(result);
    CHECK(equal(make_expected(small_scene()).tiles.at(tile.index), *result));
    CHECK_FALSE(silent.processor->take());
}

TEST_CASE("cancelling drops what has not begun, and wakes a submitter that waits for room",
          "[raytracer][sched]") {
    Silent silent(1);
    const auto tiles = list_tiles(silent.job.view.scene);
    std::thread submitter([&] {
        for (const tiles::RenderTile& tile : tiles)
            silent.processor->submit(tile);
    });
    silent.wait_until_asked();
    silent.processor->cancel();
    silent.released = true;
    submitter.join();
    std::size_t taken = 0;
    while (silent.processor->take())
        ++taken;
    CHECK(taken < tiles.size());
}

TEST_CASE("a processor with work waiting can be destroyed", "[raytracer][sched]") {
    Job job(small_scene());
    const auto tiles = list_tiles(job.view.scene);
    for (int round = 0; round < 20; ++round) {
        const auto processor = make_processor(round % 4, job.view, job.blocks);
        for (std::size_t i = 0; i < 2; ++i)
            processor->submit(tiles[i]);
        if (round % 2 == 0)
            CHECK(processor->take().has_value());
    }
}

TEST_CASE("a slice ends without an answer while a world is silent, until it is cancelled",
          "[raytracer][sched]") {
    Silent silent(kGreen);
    for (const tiles::RenderTile& tile : list_tiles(silent.job.view.scene))
        silent.processor->submit(tile);
    silent.wait_until_asked();
    CHECK_FALSE(silent.processor->wait(1ms));
    std::thread other([&] { silent.processor->cancel(); });
    CHECK_FALSE(silent.processor->take());
    other.join();
    CHECK(silent.processor->wait(1h));
}

TEST_CASE("cancelling from elsewhere ends a tile that is being traced", "[raytracer][sched]") {
    scene::Scene scene = small_scene();
    scene.quality.samples = std::numeric_limits<int>::max();  // for years
    Job job(scene);
    processors::GreenProcessor processor(job.view, job.blocks);
    processor.submit(list_tiles(scene).front());
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
