#include "raytracer/preview/live_picture.hpp"

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
using preview::ProbeRetry;

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
    /// @return how many first pictures were reported
    [[nodiscard]] int first_pictures() const { return times.report()["first_pictures"]["count"]; }
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

TEST_CASE("a first pass may continue for 50 ms after the scene has changed", "[preview]") {
    Bench bench;
    bench.update(at_azimuth(10));
    bench.now += 49ms;
    bench.update(at_azimuth(20));
    CHECK(bench.picture.started_count() == 1);
    bench.now += 1ms;
    bench.update(at_azimuth(20));
    CHECK(bench.picture.started_count() == 2);
    bench.finish();  // once the picture is whole a change waits for nothing
    bench.update(at_azimuth(30));
    CHECK(bench.picture.started_count() == 3);
}

TEST_CASE("the time of the first picture of a change is noted once", "[preview]") {
    Bench bench;
    bench.picture.note_change(bench.now);
    CHECK(bench.picture.busy());  // so that the first frame does not wait for input
    bench.update(at_azimuth(10));
    bench.picture.note_shown(bench.now);
    CHECK(bench.first_pictures() == 0);  // there is nothing to see yet
    bench.finish();
    bench.picture.note_shown(bench.now + 20ms);
    CHECK(bench.first_pictures() == 1);
    CHECK(bench.times.report()["first_pictures"]["most_s"].get<double>() == Approx(0.02));
    CHECK_FALSE(bench.picture.busy());
    bench.picture.note_shown(bench.now + 40ms);
    CHECK(bench.first_pictures() == 1);
}

TEST_CASE("a picture that began before a change is not the first one of it", "[preview]") {
    Bench bench;
    bench.update(at_azimuth(10));
    bench.picture.forget_change();
    bench.now += 10ms;
    bench.update(at_azimuth(20));  // the pass in progress may continue
    bench.finish();
    bench.picture.note_shown(bench.now);
    CHECK(bench.first_pictures() == 0);
    CHECK(bench.picture.busy());
    bench.update(at_azimuth(20));
    bench.finish();
    bench.picture.note_shown(bench.now);
    CHECK(bench.first_pictures() == 1);
}

TEST_CASE("the first pass becomes coarser when it is slow, and finer when it is quick",
          "[preview]") {
    struct Case {
        int step;
        double first_s;
        int wanted;
    };
    const auto c = GENERATE(
        values<Case>({{8, 0.031, 16}, {64, 1, 64}, {8, 0.02, 8}, {8, 0.007, 4}, {4, 0.001, 4}}));
    INFO(c.step << ", " << c.first_s << " s");
    CHECK(preview::next_first_step(c.step, c.first_s) == c.wanted);
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

TEST_CASE("while a picture is coarse, only what is new of it is developed", "[preview]") {
    Bench bench;
    bench.update(window_scene());
    bench.finish();
    (void)bench.picture.develop(window_scene().output);
    const auto before = bench.picture.screen().rgb;
    bench.update(at_azimuth(10));
    scene::Scene::Output brighter = window_scene().output;
    brighter.exposure_ev += 1;
    // No tile of the new picture is there: the old one stays as it was developed.
    CHECK(bench.picture.develop(brighter).empty());
    CHECK(bench.picture.screen().rgb == before);
    bench.finish();
    CHECK(is_all(bench.picture.develop(brighter)));
}

TEST_CASE("layers of one film are shown without a new picture", "[preview]") {
    Bench bench;
    bench.update(window_scene(), Layer::kDepth);
    bench.finish();
    (void)bench.picture.develop(window_scene().output);
    const auto depth = bench.picture.screen().rgb;
    bench.update(window_scene(), Layer::kBeauty);
    CHECK(bench.picture.started_count() == 1);
    CHECK(is_all(bench.picture.develop(window_scene().output)));
    CHECK(bench.picture.screen().rgb != depth);
    bench.update(window_scene(), Layer::kOcclusion);
    CHECK(bench.picture.started_count() == 2);
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

TEST_CASE("a box that was missing is requested again where that may help", "[preview][world]") {
    const voxel::BoxKey key{0, 0, 0, 0};
    std::atomic<bool> is_broken{true};
    auto world = test::landscape();
    world->make_hole(key, [&is_broken] {
        if (is_broken)
            throw std::runtime_error("the disk is gone");
    });
    Bench bench(std::move(world));
    bench.update(window_scene());
    bench.finish();
    REQUIRE(bench.picture.progressive().holes().contains(key));
    is_broken = false;
    bench.now += preview::HoleWatch::kFirst + 1s;
    CHECK_FALSE(bench.picture.has_missing_box_arrived(false, bench.now));
    CHECK(bench.job.blocks.is_hole(key));
    REQUIRE(
        test::eventually([&] { return bench.picture.has_missing_box_arrived(true, bench.now); }));
    bench.update(window_scene(), Layer::kBeauty, true);
    CHECK(bench.picture.started_count() == 2);
    bench.finish();
    CHECK(bench.picture.progressive().holes().empty());
}

TEST_CASE("a layer of walks is probed again until all of its boxes are in memory",
          "[preview][world]") {
    std::atomic<bool> may_load{false};
    auto world = test::landscape();
    world->delay({0, 0, 0, 0}, [&may_load] {
        while (!may_load)
            std::this_thread::sleep_for(1ms);
    });
    Bench bench(std::move(world));
    // A loader waits; it must end before the block manager does, even where a check has failed.
    struct AtEnd {
        std::atomic<bool>& may_load;
        ~AtEnd() { may_load = true; }
    } const at_end{may_load};
    const auto update = [&] {
        bench.update(window_scene(), Layer::kCache);
        bench.finish();
    };
    update();
    CHECK(bench.picture.missing() > 0);
    bench.now += ProbeRetry::kMin - 1ms;
    update();
    CHECK(bench.picture.started_count() == 1);
    bench.now += 1ms;
    update();
    CHECK(bench.picture.started_count() == 2);
    may_load = true;
    CHECK(test::eventually([&] {
        bench.now += ProbeRetry::kMax;
        update();
        return bench.picture.missing() == 0;
    }));
    const auto count = bench.picture.started_count();
    bench.now += ProbeRetry::kMax;
    update();
    CHECK(bench.picture.started_count() == count);
}

TEST_CASE("probes are repeated more and more seldom while no box arrives", "[preview]") {
    const ProbeRetry::Clock::time_point start;
    ProbeRetry retry;
    retry.begin(start);
    const auto waits = [&](std::chrono::milliseconds wait) {
        CHECK_FALSE(retry.is_due(start + wait - 1ms));
        CHECK(retry.is_due(start + wait));
    };
    waits(500ms);
    retry.note(7);  // the first: fewer than all
    waits(500ms);
    for (const auto wait : {1000ms, 2000ms, 4000ms, 8000ms, 16000ms, 16000ms}) {
        retry.note(7);
        waits(wait);
    }
    retry.note(6);
    waits(500ms);
    retry.note(6);
    waits(1000ms);
    retry.reset();
    waits(500ms);
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
