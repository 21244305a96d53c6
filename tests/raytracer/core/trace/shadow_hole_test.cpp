// A picture depends on boxes that only shadow rays meet: those that cannot be loaded are holes of
// it like any other.
#include <algorithm>

#include "raytracer/core/walk/walk.hpp"
#include "raytracer/farm/render/statistics.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using terravox::test::ArrayWorld;
using terravox::test::Job;
using terravox::test::landscape;
using terravox::test::small_scene;
using terravox::test::to_bytes;

namespace {

constexpr std::size_t kPlenty = std::size_t{256} << 20;

/// The valley's eastern slope, seen towards the east; the sun stands low in the west, beyond boxes
/// that the camera does not see.
scene::Scene eastern_slope() {
    scene::Scene scene = small_scene();
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.camera.position = {66.5, 40, 0.5};
    scene.camera.target = {88, 12, 0.5};
    scene.sun.azimuth_deg = 265;
    scene.sun.altitude_deg = 8;
    return scene;
}

std::unique_ptr<ArrayWorld> without_the_middle() {
    auto world = landscape();
    world->fill({-70, 20, -60}, {-66, 50, 60}, voxel::Material::kWall);  // beyond the holes
    for (int bz = -2; bz <= 1; ++bz)
        world->make_hole({0, 0, 0, bz});
    return world;
}

struct Picture {
    render::RenderCounts counts;
    std::string bytes;
};

Picture render_picture(scene::Scene scene, std::unique_ptr<ArrayWorld> world, int threads = 2,
                       std::size_t memory_bytes = kPlenty) {
    Job job(scene, memory_bytes, std::move(world));
    output::Film film(scene.output.size_px[0], scene.output.size_px[1]);
    processors::ThreadProcessor processor(job.view, job.blocks, threads);
    Picture out{render::render_film({job.view, processor, true, {}}, film), {}};
    out.bytes = to_bytes(film);
    return out;
}

}  // namespace

TEST_CASE("a hole that only shadow rays meet is one of the picture's", "[raytracer][world][hole]") {
    const Picture holed = render_picture(eastern_slope(), without_the_middle());
    const Picture whole = render_picture(eastern_slope(), landscape());
    CHECK_FALSE(holed.counts.holes.empty());
    CHECK(std::all_of(holed.counts.holes.begin(), holed.counts.holes.end(),
                      [](const voxel::BoxKey& key) { return key.bx == 0 && key.by == 0; }));
    CHECK(holed.counts.trace.hole_rays > 0);
    CHECK(holed.bytes != whole.bytes);
    CHECK(whole.counts.holes.empty());
    CHECK(whole.counts.trace.hole_rays == 0);
    scene::Scene bright = eastern_slope();
    bright.quality.shadows = false;
    const Picture unshadowed = render_picture(bright, without_the_middle());
    CHECK(unshadowed.counts.holes.empty());
    CHECK(unshadowed.counts.trace.hole_rays == 0);
}

TEST_CASE("the holes that a picture reports do not depend on threads, tiles or memory",
          "[raytracer][world][hole][deterministic]") {
    const Picture reference = render_picture(eastern_slope(), without_the_middle(), 1);
    struct Case {
        const char* name;
        int threads;
        int tile_px;
        core::TileOrder order;
        std::size_t memory_bytes;
    };
    for (const Case& c : {Case{"four threads", 4, 16, core::TileOrder::kSpiral, kPlenty},
                          {"small tiles", 2, 5, core::TileOrder::kHilbert, kPlenty},
                          {"one tile", 1, 1000, core::TileOrder::kRows, kPlenty},
                          {"hardly any memory", 3, 16, core::TileOrder::kVertical, 1}}) {
        INFO(c.name);
        scene::Scene scene = eastern_slope();
        scene.quality.tile = {c.tile_px};
        scene.quality.tile_order = c.order;
        const Picture other =
            render_picture(scene, without_the_middle(), c.threads, c.memory_bytes);
        CHECK(other.counts.holes == reference.counts.holes);
        CHECK(other.counts.trace.hole_rays == reference.counts.trace.hole_rays);
        CHECK(other.bytes == reference.bytes);
    }
}

TEST_CASE("a hole before a brick is met, whichever ray has found the brick",
          "[raytracer][world][hole][walk]") {
    ArrayWorld world({-64, 0, 0}, {192, 64, 64});
    world.fill({-40, 0, 0}, {-36, 64, 64}, voxel::Material::kRock);
    world.fill({130, 0, 0}, {131, 1, 1}, voxel::Material::kRock);
    world.make_hole({0, 0, 0, 0});
    blocks::BlockManager blocks(world, kPlenty);
    for (int bx = -1; bx <= 2; ++bx)
        (void)blocks.get({0, bx, 0, 0});
    const walk::LevelCut cut(world.info().bounds, 0);
    walk::BlockReader reader(blocks);
    walk::RayWalk walk(reader, cut);
    walk::Occluder occluder;
    const auto hits_from = [&](double x) {
        core::RayState state(core::Ray{{x, 10.3, 10.4}, {-1, 0.001, 0.001}});
        REQUIRE(state.enter(cut.entry_bounds()));
        return walk.any_hit(state, core::kFar, occluder) == walk::WalkEnd::kHit;
    };
    CHECK(hits_from(-10.5));
    CHECK_FALSE(occluder.hole);
    CHECK(occluder.mask != 0);
    CHECK(walk.take_holes().empty());
    for (const double x : {70.5, 150.5, 30.5, 190.5}) {  // next to the hole, far from it, in it
        INFO("from " << x);
        CHECK(hits_from(x));
        CHECK(occluder.hole);
        CHECK(walk.take_holes() == std::set<voxel::BoxKey>{{0, 0, 0, 0}});
    }
    CHECK(hits_from(-10.5));
    CHECK_FALSE(occluder.hole);
    CHECK(walk.take_holes().empty());
}
