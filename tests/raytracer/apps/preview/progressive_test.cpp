#include "raytracer/apps/preview/progressive.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include "common/util/error.hpp"
#include "raytracer/apps/preview/layers.hpp"
#include "raytracer/apps/preview/live_picture.hpp"
#include "raytracer/apps/preview/pick_tool.hpp"
#include "raytracer/apps/preview/probe_processor.hpp"
#include "raytracer/farm/processors/green_processor.hpp"
#include "raytracer/farm/processors/processor_pool.hpp"
#include "tests/catch.hpp"
#include "tests/eventually.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using namespace std::chrono_literals;
using terravox::test::Job;
using terravox::test::small_scene;

namespace {

preview::Progressive::Begin green(blocks::BlockManager& blocks) {
    return [&blocks](const shade::View& view) {
        return std::make_shared<processors::GreenProcessor>(view, blocks);
    };
}
preview::Progressive::Begin threads(blocks::BlockManager& blocks, int count) {
    return [&blocks, count](const shade::View& view) {
        return std::make_shared<processors::ThreadProcessor>(view, blocks, count);
    };
}

void finish(preview::Progressive& picture) {
    while (picture.busy())
        picture.work(preview::Progressive::Clock::now() + 50ms);
}

// The mean of samples that were added one by one is not the same to the last bit.
void check_like(const output::Film& is, const output::Film& wanted) {
    for (int y = 0; y < wanted.height_px(); ++y)
        for (int x = 0; x < wanted.width_px(); ++x) {
            const voxel::Colour a = is.at(x, y).colour;
            const voxel::Colour b = wanted.at(x, y).colour;
            if (std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b) >
                1e-4f * (1 + b.r + b.g + b.b))
                FAIL("pixel " << x << ", " << y << ": " << a.r << " for " << b.r);
        }
}

}  // namespace

TEST_CASE("a picture rendered in slices equals one rendered at once", "[preview]") {
    const int step = GENERATE(1, 8, 64);
    const int samples = GENERATE(1, 5);
    scene::Scene scene = small_scene();
    scene.quality.samples = samples;
    Job job(scene);
    preview::Progressive picture(
        job.blocks, GENERATE(true, false) ? green(job.blocks) : threads(job.blocks, 2));
    picture.start(scene, step);
    CHECK(picture.busy());
    CHECK_FALSE(picture.whole());
    finish(picture);
    CHECK(picture.whole());
    CHECK(picture.status().samples == static_cast<std::uint32_t>(samples));
    CHECK(picture.status().first_s > 0);
    for (int y = 0; y < picture.film()->height_px(); ++y)
        REQUIRE(picture.film()->at(3, y).samples == static_cast<std::uint32_t>(samples));
    check_like(*picture.film(), test::render_scene(job, 2));
}

TEST_CASE("a screen that is shown what has changed, tile by tile, shows the film", "[preview]") {
    scene::Scene scene = small_scene();
    scene.output.size_px = {130, 71};
    scene.quality.samples = GENERATE(1, 3);
    Job job(scene);
    preview::Progressive picture(job.blocks, green(job.blocks));
    picture.start(scene, GENERATE(1, 4, 16));
    preview::ScreenPicture screen;
    preview::ScreenPicture wanted;
    screen.resize(130, 71);
    wanted.resize(130, 71);
    const auto show_to = [&](preview::ScreenPicture& to, const tiles::RenderTile& tile) {
        preview::show(*picture.film(), *picture.view(), scene.output, preview::Layer::kBeauty, tile,
                      to);
    };
    const auto show_changes = [&] {
        for (const tiles::RenderTile& tile : picture.take_changes())
            show_to(screen, tile);
    };
    tiles::RenderTile all;
    all.x1 = 130;
    all.y1 = 71;
    while (!picture.whole()) {
        picture.work(preview::Progressive::Clock::now() + 1ms);
        show_changes();
    }
    while (picture.busy()) {
        picture.work(preview::Progressive::Clock::now() + 1ms);
        show_changes();
    }
    show_to(wanted, all);
    CHECK(screen.rgb == wanted.rgb);
}

TEST_CASE(
    "boxes that could not be loaded are requested again, at growing intervals, until they arrive",
    "[preview][world]") {
    using Clock = preview::HoleWatch::Clock;
    const auto world = test::landscape();
    const voxel::BoxKey broken{0, 0, 0, 0};
    world->make_hole(broken);
    blocks::BlockManager blocks(*world, GENERATE(std::size_t{1}, std::size_t{64} << 20));
    REQUIRE(blocks.get(broken)->hole);
    const std::set<voxel::BoxKey> holes{broken};
    preview::HoleWatch watch(blocks);
    const Clock::time_point start;
    const auto look = [&](int second) {
        return watch.look(holes, start, start + std::chrono::seconds(second));
    };
    CHECK_FALSE(watch.look({}, start, start + 100s));
    const auto asked = world->requests();
    CHECK_FALSE(look(9));
    CHECK(world->requests() == asked);
    CHECK_FALSE(look(11));
    // Listeners to a box are called in the order in which they began to wait for it: the watch has
    // its answer once this one has.
    struct After final : blocks::BlockListener {
        bool on_block_loaded(const voxel::BoxKey&, std::uint64_t) noexcept override {
            return came = true;
        }
        std::atomic<bool> came{false};
    };
    After after;
    blocks.wait_for(broken, after, 0);
    REQUIRE(test::eventually([&] { return after.came.load(); }));
    CHECK(world->requests() == asked + 1);
    CHECK_FALSE(look(12));  // a hole again: 20 seconds from now on
    blocks.forget(after);
    CHECK_FALSE(look(31));
    CHECK(world->requests() == asked + 1);
    world->mend_hole(broken);
    CHECK(test::eventually([&] { return look(33); }));
    CHECK(world->requests() == asked + 2);
}

TEST_CASE("layers show what their descriptions say", "[preview]") {
    scene::Scene scene = small_scene();
    auto world = test::landscape();
    world->editable_info().centre = geo::MapPlace{46, 14.5};
    Job job(scene, std::size_t{256} << 20, std::move(world));
    preview::ScreenPicture screen;
    const preview::Layer layer = GENERATE(from_range(std::vector<preview::Layer>{
        preview::Layer::kBeauty, preview::Layer::kDirect, preview::Layer::kDepth,
        preview::Layer::kNormal, preview::Layer::kAlbedo, preview::Layer::kMaterial,
        preview::Layer::kSunlight, preview::Layer::kSunHours, preview::Layer::kOcclusion,
        preview::Layer::kLevels, preview::Layer::kSteps, preview::Layer::kCache}));
    const auto facts = std::find_if(preview::kLayers.begin(), preview::kLayers.end(),
                                    [&](const preview::LayerFacts& l) { return l.layer == layer; });
    REQUIRE(facts != preview::kLayers.end());
    INFO(facts->name);
    // The boxes must be in memory before they are read without waiting.
    (void)test::render_scene(job, 1);
    preview::Progressive picture(
        job.blocks, [&](const shade::View& view) -> std::shared_ptr<processors::TileProcessor> {
            if (preview::is_probe(layer))
                return std::make_shared<preview::ProbeProcessor>(view, job.blocks, layer);
            return std::make_shared<processors::GreenProcessor>(view, job.blocks);
        });
    picture.start(preview::scene_for(layer, scene), 8);
    finish(picture);
    screen.resize(97, 53);
    tiles::RenderTile all;
    all.x1 = 97;
    all.y1 = 53;
    preview::show(*picture.film(), *picture.view(), scene.output, layer, all, screen);
    std::set<int> colours;
    for (std::size_t i = 0; i < screen.rgb.size(); i += 3)
        colours.insert(screen.rgb[i] << 16 | screen.rgb[i + 1] << 8 | screen.rgb[i + 2]);
    CHECK(colours.size() > 2);
}

TEST_CASE("a box that is not in memory is shown as such, and is loaded", "[preview]") {
    scene::Scene scene = small_scene();
    Job job(scene);
    std::shared_ptr<preview::ProbeProcessor> probe;
    preview::Progressive picture(job.blocks, [&](const shade::View& view) {
        probe = std::make_shared<preview::ProbeProcessor>(view, job.blocks, preview::Layer::kCache);
        return std::shared_ptr<processors::TileProcessor>(probe);
    });
    CHECK(test::eventually([&] {
        picture.start(preview::scene_for(preview::Layer::kCache, scene), 8);
        finish(picture);
        return probe->missing() == 0;
    }));
}

TEST_CASE("a picked voxel is the one that the ray meets", "[preview]") {
    scene::Scene scene = small_scene();
    Job job(scene);
    preview::Picker picker(job.blocks);
    const auto view = std::make_shared<const shade::View>(job.view);
    const auto answer_to = [&](const core::Ray& ray) {
        picker.ask(preview::Picker::Use::kRead, view, ray);
        std::optional<preview::Picker::Answer> answer;
        while (!(answer = picker.take()))
            std::this_thread::sleep_for(1ms);
        return answer->picked;
    };
    const auto roof = answer_to(preview::plumb_line(job.blocks.world_info(), 30.5, 30.5));
    REQUIRE(roof);
    CHECK(roof->voxel == core::VoxelCoord{30, 22, 30});
    CHECK(roof->attr.material == voxel::Material::kOrangeRoof);
    CHECK(roof->point.y == Approx(23));
    CHECK_FALSE(answer_to({{0, 100, 0}, {0, 1, 0}}));
    const auto facts = preview::collect_facts(*roof, job.blocks.world_info());
    const auto value = [&](const std::string& name) {
        for (const preview::PickedFact& f : facts)
            if (f.name == name)
                return f.value;
        return std::string("(none)");
    };
    CHECK(value("voxel") == "30, 22, 30");
    CHECK(value("height") == "23.00 m");
    CHECK(value("material") == "orange_roof");
    // The last question counts.
    for (int i = 0; i < 50; ++i)
        picker.ask(preview::Picker::Use::kRead, view,
                   preview::plumb_line(job.blocks.world_info(), 30.5, 30.5));
    const auto sky = answer_to({{0, 100, 0}, {0, 1, 0}});
    CHECK_FALSE(sky);
}
