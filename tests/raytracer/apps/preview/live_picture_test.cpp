#include "raytracer/apps/preview/live_picture.hpp"

#include <atomic>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/eventually.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using namespace std::chrono_literals;
using preview::Layer;
using preview::LivePicture;

namespace {

/// As in the window: the camera may be inside rock, so that no box is needed to check that.
scene::Scene window_scene() {
    scene::Scene out = test::small_scene();
    out.camera.inside_rock = true;
    return out;
}

constexpr int kHeight_px = 53;  // of window_scene()

render::RenderPoolOptions green_pool() {
    render::RenderPoolOptions out;
    out.threads = 0;
    out.green = true;
    return out;
}

/// A live picture whose clock stands still between calls.
struct Bench {
    test::Job job;
    preview::FrameTimes times;
    LivePicture picture;
    LivePicture::Clock::time_point now = LivePicture::Clock::time_point() + 1h;

    explicit Bench(std::unique_ptr<test::ArrayWorld> world = test::landscape())
        : job(window_scene(), std::size_t{256} << 20, std::move(world)),
          picture(green_pool(), job.blocks, {}, times) {}

    void update(const scene::Scene& wanted, Layer layer = Layer::kBeauty, bool restart = false) {
        picture.update(preview::scene_for(layer, wanted), layer, restart, now, now);
    }
    void finish() {
        while (picture.progressive().busy())
            picture.work(LivePicture::Clock::now() + 50ms);
    }
};

scene::Scene at_azimuth(double azimuth_deg) {
    scene::Scene out = window_scene();
    out.sun.azimuth_deg = azimuth_deg;
    return out;
}

bool is_all(const preview::RowRange& rows) {
    return rows.first == 0 && rows.end == kHeight_px;
}

}  // namespace

TEST_CASE("the picture starts when the scene changes, and only then", "[preview]") {
    Bench bench;
    CHECK_FALSE(bench.picture.busy());
    bench.update(at_azimuth(10));
    CHECK(bench.picture.started_count() == 1);
    CHECK(bench.picture.busy());
    bench.finish();
    bench.update(at_azimuth(10));
    CHECK(bench.picture.started_count() == 1);
    bench.update(at_azimuth(20));
    CHECK(bench.picture.started_count() == 2);
    bench.finish();
    bench.update(at_azimuth(20), Layer::kBeauty, true);
    CHECK(bench.picture.started_count() == 3);
    bench.finish();
    bench.picture.invalidate();
    bench.update(at_azimuth(20));
    CHECK(bench.picture.started_count() == 4);
}

TEST_CASE("exposure and tone develop the film again, without a new picture", "[preview]") {
    Bench bench;
    scene::Scene scene = window_scene();
    const preview::Pane pane{0, 0, scene.output.size_px[0], scene.output.size_px[1]};
    const auto update = [&] {
        bench.update(preview::scene_to_show(Layer::kBeauty, scene, 1, pane));
    };
    update();
    bench.finish();
    CHECK(is_all(bench.picture.develop(scene.output)));
    CHECK(bench.picture.develop(scene.output).empty());
    const auto before = bench.picture.screen().rgb;
    scene.output.exposure_ev -= 2;
    update();
    CHECK(bench.picture.started_count() == 1);
    CHECK(is_all(bench.picture.develop(scene.output)));
    CHECK(bench.picture.screen().rgb != before);
    CHECK(bench.picture.develop(scene.output).empty());
}

TEST_CASE("a scene that cannot be rendered is reported once, and the next one is rendered",
          "[preview]") {
    Bench bench;
    bench.update(window_scene());
    bench.finish();
    scene::Scene bad = window_scene();
    bad.quality.level = 20;
    bad.output.size_px = {3000, 2000};
    CHECK_THROWS_AS(bench.update(bad), util::UsageError);
    CHECK_FALSE(bench.picture.busy());
    CHECK_NOTHROW(bench.update(bad));
    CHECK(bench.picture.started_count() == 1);
    CHECK(bench.picture.screen().height_px == kHeight_px);  // what was there stays
    bench.update(window_scene());
    CHECK(bench.picture.started_count() == 2);
    bench.finish();
    CHECK(bench.picture.progressive().whole());
}

TEST_CASE("the scene to show has the size of the pane, and nothing that only develops",
          "[preview]") {
    scene::Scene scene = window_scene();
    scene.output.exposure_ev = 3;
    scene.output.credit = true;
    const scene::Scene shown = preview::scene_to_show(Layer::kBeauty, scene, 0.5, {10, 20, 301, 1});
    CHECK(shown.output.size_px == std::array{151, 1});
    CHECK(shown.output.exposure_ev == scene::Scene::Output().exposure_ev);
    CHECK_FALSE(shown.output.credit);
    CHECK(shown.sun == scene.sun);
    CHECK(shown.quality == scene.quality);
}
