// What is measured does not depend on when a thread had to stop, nor on which box was there first.
#include "raytracer/core/trace/tile_job.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/analyse/evaluators/period_light.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;

namespace {

constexpr int kSide = 40;

struct Case {
    const char* name;
    scene::Scene scene;
};

std::vector<Case> cases() {
    std::vector<Case> out;
    scene::Scene sky = test::analysis_scene(core::AnalysisKind::kSky);
    sky.analysis.directions = 40;
    out.push_back({"sky", sky});
    sky.analysis.range_m = 9;
    out.push_back({"sky with a range", sky});
    out.push_back({"hours of sun",
                   test::energy_scene(core::AnalysisKind::kSunMonths, "2026-02-01", "2026-05-01")});
    scene::Scene energy =
        test::energy_scene(core::AnalysisKind::kEnergy, "2026-02-01", "2026-03-01");
    energy.analysis.directions = 40;
    energy.analysis.crown_light = "0.3";
    out.push_back({"energy", energy});
    energy.analysis.kind = core::AnalysisKind::kFacade;
    out.push_back({"facades", energy});
    return out;
}

std::unique_ptr<test::ArrayWorld> valley(bool has_hole) {
    auto world = test::landscape();
    world->editable_info().centre = test::kTown;
    if (has_hole)
        world->make_hole({0, 1, 0, 0});
    return world;
}

scene::Scene over_the_house(const Case& c, const voxel::World& world) {
    scene::Scene out = c.scene;
    analyse::look_at_cells(analyse::grid_over(world.info(), {{25, -10, 10}, {65, 60, 50}}, 1),
                           world.info(), out);
    return out;
}

tiles::TileResult traced(test::Job& job, const thread::StopCondition& stop) {
    trace::TracerTools tools(job.view, job.blocks, std::size_t{1} << 20);
    trace::TileJob tile;
    tile.start({0, 0, 0, 0, kSide, kSide}, 256);
    while (!tile.run(tools, stop))
        for (const voxel::BoxKey& key : tile.take_missing()) {
            (void)job.blocks.get(key);
            tile.on_box_loaded(key);
        }
    return tile.take_result();
}

}  // namespace

TEST_CASE("a tile of an analysis that is stopped again and again has the same values",
          "[raytracer][analyse][trace][hole]") {
    std::stop_source stopped;
    stopped.request_stop();
    const bool has_hole = GENERATE(false, true);
    for (const Case& c : cases()) {
        INFO(c.name << (has_hole ? ", with a hole" : ""));
        auto world = valley(has_hole);
        const scene::Scene scene = over_the_house(c, *world);
        test::Job job(scene, std::size_t{256} << 20, std::move(world), analyse::measure);
        // The first run finds none of the boxes.
        const tiles::TileResult pieces = traced(job, thread::StopCondition(stopped.get_token()));
        const tiles::TileResult whole = traced(job, thread::StopCondition({}));
        CHECK(whole.bands.size() == kSide * kSide * job.view.bands());
        CHECK(pieces.bands == whole.bands);
        CHECK(pieces.counts.rays == whole.counts.rays);
        CHECK(pieces.counts.hole_rays == whole.counts.hole_rays);
        CHECK((pieces.counts.hole_rays > 0) == has_hole);
    }
}

TEST_CASE("what is measured is the same for any tile size and number of threads",
          "[raytracer][analyse][deterministic]") {
    std::vector<Case> all = cases();
    all.push_back({"terrain", test::analysis_scene(core::AnalysisKind::kTerrain)});
    scene::Scene sight = test::analysis_scene(core::AnalysisKind::kSight);
    sight.analysis.observers.points = {{30.5, 40, 20.5}, {60.5, 45, 45.5}};
    all.push_back({"sight", sight});
    scene::Scene day = test::analysis_scene(core::AnalysisKind::kSun);
    day.sun.date = "2026-09-01";
    day.sun.utc_offset_h = 1;
    all.push_back({"sun of a day", day});
    all.push_back({"sun of a period",
                   test::energy_scene(core::AnalysisKind::kSunPeriod, "2026-01-15", "2026-02-03")});
    scene::Scene ground =
        test::energy_scene(core::AnalysisKind::kEnergy, "2026-09-01", "2026-09-05");
    ground.analysis.surface = core::AnalysisSurface::kGround;
    ground.analysis.diffuse = "perez";
    all.push_back({"energy of the ground", ground});
    const auto world = valley(false);
    test::Measured::Options plain;
    plain.area = voxel::VoxelBounds{{25, -10, 10}, {65, 60, 50}};
    test::Measured::Options other = plain;
    other.threads = 3;
    other.tile_px = 7;
    for (const Case& c : all) {
        INFO(c.name);
        CHECK(test::Measured(*world, c.scene, plain).values() ==
              test::Measured(*world, c.scene, other).values());
    }
}
