#include "raytracer/core/trace/ray_wave.hpp"

#include <numeric>

#include "raytracer/core/trace/tile_job.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using terravox::test::Job;
using terravox::test::small_scene;

namespace {

const thread::StopCondition kNever({});

/// All pixels of a tile in one part, and a wave of rays through them.
struct Begun {
    explicit Begun(Job& job) : tools(job.view, job.blocks, std::size_t{1} << 20) {
        pixels.start({0, 0, 0, 0, 48, 48});
        samples.resize(pixels.cut(job.view.camera, tools.beams));
        pixels.next_part(1000);
        active.resize(samples.size());
        std::iota(active.begin(), active.end(), 0U);
        trace::PrimaryRays(tools, pixels.pixels(), active, samples, wave, counts).make(0);
    }
    trace::TracerTools tools;
    trace::TilePixels pixels;
    std::vector<shade::SampleSum> samples;
    std::vector<std::uint32_t> active;
    trace::RayWave wave;
    tiles::TraceCounts counts;
};

void load(Job& job, trace::RayWave& wave) {
    const auto missing = wave.take_missing();
    REQUIRE_FALSE(missing.empty());
    for (const voxel::BoxKey& key : missing) {
        (void)job.blocks.get(key);
        wave.on_box_loaded(key);
    }
    CHECK(wave.take_missing().empty());
}

}  // namespace

TEST_CASE("a ray whose box is missing is parked until the box is loaded", "[raytracer][trace]") {
    Job job(small_scene());
    Begun begun(job);
    CHECK(begun.counts.rays[static_cast<std::size_t>(walk::RayKind::kPrimary)] == 48 * 48);
    CHECK_FALSE(begun.wave.walk(begun.tools, begun.samples, kNever, begun.counts));
    CHECK(begun.wave.waits());
    CHECK(begun.counts.parked > 0);
    // Without a box no ray continues.
    const auto parked = begun.counts.parked;
    CHECK_FALSE(begun.wave.walk(begun.tools, begun.samples, kNever, begun.counts));
    CHECK(begun.counts.parked == parked);
    do
        load(job, begun.wave);
    while (!begun.wave.walk(begun.tools, begun.samples, kNever, begun.counts));
    CHECK_FALSE(begun.wave.waits());
}

TEST_CASE("a tile that is stopped again and again has the same pixels", "[raytracer][trace]") {
    Job job(small_scene());
    trace::TracerTools tools(job.view, job.blocks, std::size_t{1} << 20);
    std::stop_source stopped;
    stopped.request_stop();
    const thread::StopCondition at_once(stopped.get_token());
    const auto traced = [&](const thread::StopCondition& stop) {
        trace::TileJob tile;
        tile.start({0, 0, 0, 0, 40, 40}, 256);
        while (!tile.run(tools, stop))
            for (const voxel::BoxKey& key : tile.take_missing()) {
                (void)job.blocks.get(key);
                tile.on_box_loaded(key);
            }
        return tile.take_result();
    };
    const tiles::TileResult whole = traced(kNever);
    const tiles::TileResult pieces = traced(at_once);
    REQUIRE(whole.samples.size() == 1600);
    REQUIRE(pieces.samples.size() == 1600);
    for (std::size_t i = 0; i < whole.samples.size(); ++i) {
        CHECK(whole.samples[i].colour.r == pieces.samples[i].colour.r);
        CHECK(whole.samples[i].depth_m == pieces.samples[i].depth_m);
    }
}
