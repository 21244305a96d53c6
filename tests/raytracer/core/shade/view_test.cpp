#include <memory>
#include <utility>

#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using terravox::test::Job;
using terravox::test::small_scene;

TEST_CASE("what measures must be given to the view of a scene that is no picture",
          "[raytracer][render][analyse]") {
    Job job(small_scene());
    scene::Scene scene = small_scene();
    scene.analysis.kind = core::AnalysisKind::kSky;
    CHECK_THROWS_WITH(shade::make_view(scene, job.blocks),
                      test::contains("allowed for pictures: none"));
    const auto measure = [](const scene::Scene&, const voxel::WorldInfo&) {
        auto out = std::make_shared<shade::Measuring>();
        out->bands = 3;
        out->thin_things = walk::ThinThings::kPass;
        return std::shared_ptr<const shade::Measuring>(std::move(out));
    };
    const shade::View view = shade::make_view(scene, job.blocks, measure);
    CHECK(view.bands() == 3);
    CHECK(view.content().bands == 3);
    CHECK(view.thin_things() == walk::ThinThings::kPass);
    CHECK(job.view.bands() == 0);
    CHECK(job.view.thin_things() == walk::ThinThings::kBlock);
}

TEST_CASE("the exposure follows dusk and night without a jump, and leaves the day alone",
          "[raytracer][render][light]") {
    Job job(small_scene());
    const auto exposure = [&](double altitude_deg, double adaptation) {
        scene::Scene scene = small_scene();
        scene.sun.altitude_deg = altitude_deg;
        scene.output.adaptation = adaptation;
        scene.output.exposure_ev = 0.5;
        return shade::make_view(scene, job.blocks).exposure_ev;
    };
    CHECK(exposure(45, 1) == 0.5);
    CHECK(exposure(-9, 0) == 0.5);
    double last = exposure(8, 0.75);
    for (double altitude = 6; altitude >= -18; altitude -= 2) {
        const double now = exposure(altitude, 0.75);
        INFO("sun at " << altitude << " degrees");
        CHECK(now >= last - 0.05);
        CHECK(now - last < 3);
        last = now;
    }
    CHECK(last > 6);
    CHECK(last <= 9.5);
}
