#include <algorithm>
#include <filesystem>
#include <thread>

#include "common/util/error.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/core/shade/view.hpp"
#include "raytracer/farm/render/statistics.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"
#include "tests/raytracer/pyramid_world.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"

using namespace terravox;
using terravox::test::Job;
using terravox::test::landscape;
using terravox::test::render_scene;
using terravox::test::small_scene;
using terravox::test::to_bytes;

namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;

struct Variant {
    const char* name;
    int threads;
    int tile_px;
    int coarse_step;
    core::TileOrder order;
    std::size_t memory_bytes;
};

const Variant kVariants[] = {
    {"two threads", 2, 16, 8, core::TileOrder::kSpiral, 256 * kMiB},
    {"four threads, large tiles", 4, 64, 8, core::TileOrder::kRows, 256 * kMiB},
    {"one tile", 2, 1000, 8, core::TileOrder::kSpiral, 256 * kMiB},
    {"a single pass", 2, 16, 1, core::TileOrder::kVertical, 256 * kMiB},
    {"many passes", 3, 7, 64, core::TileOrder::kSpiral, 256 * kMiB},
    {"one byte of memory", 2, 16, 8, core::TileOrder::kRows, 1},
    {"1 MiB of memory", 1, 64, 1, core::TileOrder::kSpiral, kMiB},
    {"as at first", 1, 16, 8, core::TileOrder::kSpiral, 256 * kMiB},
    {"along a Hilbert curve", 3, 5, 8, core::TileOrder::kHilbert, 256 * kMiB},
    {"split columns", 2, 9, 4, core::TileOrder::kVerticalSplit, 256 * kMiB},
};

scene::Scene with(scene::Scene scene, const Variant& v) {
    scene.quality.tile = {v.tile_px};
    scene.quality.coarse_step = v.coarse_step;
    scene.quality.tile_order = v.order;
    return scene;
}

}  // namespace

TEST_CASE("a picture is bit-identical for any threads, tiles, order, passes and memory",
          "[raytracer][render][deterministic]") {
    const auto reference = [] {
        Job job(small_scene());
        return to_bytes(render_scene(job, 1));
    }();
    for (const Variant& v : kVariants) {
        DYNAMIC_SECTION(v.name) {
            Job job(with(small_scene(), v), v.memory_bytes);
            CHECK((to_bytes(render_scene(job, v.threads)) == reference));
            constexpr std::size_t kFewBoxes =
                400'000;  // those in use stay, even where nothing fits
            CHECK(job.blocks.stats().peak_bytes <= std::max(v.memory_bytes, kFewBoxes));
        }
    }
}

TEST_CASE(
    "pictures of all kinds of rays are bit-identical for any threads, tiles, order, passes and "
    "memory",
    "[raytracer][render][deterministic][light]") {
    struct Kind {
        const char* name;
        void (*set)(scene::Scene&);
    };
    const Kind kinds[] = {
        {"ambient occlusion",
         [](scene::Scene& s) {
             s.quality.ao_rays = 5;
             s.sun.size = 10;
         }},
        {"paths",
         [](scene::Scene& s) {
             s.quality.integrator = core::Integrator::kPath;
             s.quality.samples = 3;
         }},
        {"paths until the noise is low",
         [](scene::Scene& s) {
             s.quality.integrator = core::Integrator::kPath;
             s.quality.samples = 24;
             s.quality.noise = 0.1;
             s.quality.min_samples = 4;
         }},
        {"layers", [](scene::Scene& s) { s.output.layers = core::PictureLayers::kAll; }},
    };
    for (const Kind& kind : kinds) {
        scene::Scene scene = small_scene();
        // Small: with a byte of memory nearly each ray loads its boxes again.
        scene.output.size_px = {23, 15};
        kind.set(scene);
        const auto picture = [&](const Variant& v) {
            Job job(with(scene, v), v.memory_bytes);
            return to_bytes(render_scene(job, v.threads));
        };
        const std::string reference =
            picture({"as at first", 1, 16, 8, core::TileOrder::kSpiral, 256 * kMiB});
        for (const std::size_t i : {0u, 2u, 4u, 5u}) {
            INFO(kind.name << ", " << kVariants[i].name);
            CHECK((picture(kVariants[i]) == reference));
        }
    }
}

namespace {

struct PictureOfLevels {
    std::string bytes;
    render::RenderCounts counts;
};

PictureOfLevels picture_of_levels(terravox::test::PyramidWorld& world, const scene::Scene& scene,
                                  const Variant& v) {
    const scene::Scene s = with(scene, v);
    blocks::BlockManager blocks(world, v.memory_bytes, 2);
    const shade::View view = shade::make_view(s, blocks);
    CHECK(view.cut.coarsest() > 0);
    const auto [width, height] = s.output.size_px;
    output::Film film(width, height);
    processors::ThreadProcessor processor(view, blocks, v.threads);
    PictureOfLevels out{{}, render::render_film({view, processor, true, {}}, film)};
    out.bytes = to_bytes(film);
    return out;
}

}  // namespace

TEST_CASE("a picture over several levels is bit-identical for any threads, tiles and memory",
          "[raytracer][render][deterministic][levels]") {
    const double detail = GENERATE(4.0, 20.0);
    const double sun_azimuth_deg =
        GENERATE(240.0, 0.0);  // in the north: rays with a component of exactly zero
    scene::Scene scene = small_scene();
    scene.quality.detail = detail;
    scene.sun.azimuth_deg = sun_azimuth_deg;
    scene.sun.altitude_deg = 20;
    scene.camera.azimuth_deg = sun_azimuth_deg;
    scene.camera.down_deg = 20;
    terravox::test::PyramidWorld world(landscape(), 4);
    const std::string reference = picture_of_levels(world, scene, kVariants[0]).bytes;
    for (const std::size_t i : {2u, 4u, 5u, 9u}) {
        INFO(kVariants[i].name << ", detail " << detail << ", sun at " << sun_azimuth_deg);
        CHECK((picture_of_levels(world, scene, kVariants[i]).bytes == reference));
    }
}

TEST_CASE("lamps on several levels are the same light for any threads, tiles and memory",
          "[raytracer][render][deterministic][levels][lamp]") {
    scene::Scene scene = small_scene();
    scene.quality.integrator = GENERATE(core::Integrator::kDirect, core::Integrator::kPath);
    scene.quality.detail = 4;
    scene.sun.altitude_deg = -30;
    scene.camera.down_deg = 20;
    auto land = landscape();
    for (int x = -60; x < 70; x += 9)
        land->fill({x, 14, x / 2}, {x + 1, 16, x / 2 + 1}, voxel::Material::kLamp);
    terravox::test::PyramidWorld lit(std::move(land), 4);
    terravox::test::PyramidWorld dark(landscape(), 4);
    const auto lamp = static_cast<std::size_t>(walk::RayKind::kLamp);
    const PictureOfLevels reference = picture_of_levels(lit, scene, kVariants[0]);
    CHECK(reference.counts.trace.rays[lamp] > 0);
    CHECK(picture_of_levels(dark, scene, kVariants[0]).counts.trace.rays[lamp] == 0);
    for (const std::size_t i : {2u, 4u, 5u, 9u}) {
        INFO(kVariants[i].name);
        CHECK((picture_of_levels(lit, scene, kVariants[i]).bytes == reference.bytes));
    }
}

TEST_CASE("fetching boxes ahead does not change the picture",
          "[raytracer][render][deterministic]") {
    Job plain(small_scene()), ahead(small_scene());
    render::prefetch_visible(ahead.view, ahead.blocks);
    CHECK((to_bytes(render_scene(plain, 2)) == to_bytes(render_scene(ahead, 2))));
}

TEST_CASE("a picture names whose its data are, and their licence once", "[raytracer][render]") {
    struct Case {
        const char* attribution;
        const char* licence;
        const char* copyright;
    };
    const auto c = GENERATE(values<Case>({{"ARSO", "CC BY 4.0", "ARSO, CC BY 4.0"},
                                          {"ARSO, CC BY 4.0", "CC BY 4.0", "ARSO, CC BY 4.0"},
                                          {"ARSO", "", "ARSO"},
                                          {"", "CC0", "CC0"},
                                          {"", "", nullptr}}));
    auto world = landscape();
    world->editable_info().attribution = c.attribution;
    world->editable_info().licence = c.licence;
    const Job job(small_scene(), 256 * kMiB, std::move(world));
    const auto metadata = render::picture_info(job.view, job.world->info(), {}, false).metadata;
    const auto found = std::find_if(metadata.begin(), metadata.end(),
                                    [](const auto& entry) { return entry.first == "Copyright"; });
    REQUIRE((found != metadata.end()) == (c.copyright != nullptr));
    if (c.copyright != nullptr)
        CHECK(found->second == c.copyright);
}

TEST_CASE("a hole that no ray meets is none of the picture's", "[raytracer][render]") {
    auto world = landscape();
    for (int bx = -2; bx < 2; ++bx)
        for (int bz = -2; bz < 2; ++bz)
            world->make_hole({0, bx, -1, bz});  // all below the ground
    scene::Scene scene = small_scene();
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.camera.position = {0.5, 50, 0.5};
    scene.camera.target = {10, 90, 10};
    Job job(scene, 256 * kMiB, std::move(world));
    render::prefetch_visible(job.view, job.blocks);
    while (job.blocks.hole_count() == 0)
        std::this_thread::yield();
    output::Film film(scene.output.size_px[0], scene.output.size_px[1]);
    processors::ThreadProcessor processor(job.view, job.blocks, 2);
    CHECK(render::render_film({job.view, processor, true, {}}, film).holes.empty());
}

TEST_CASE("a camera in rock is refused with advice, unless it is allowed", "[raytracer][render]") {
    scene::Scene scene = small_scene();
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.camera.position = {60.5, 3.5, 60.5};
    scene.camera.target = {0, 0, 0};
    CHECK_THROWS_AS(Job(scene), util::UsageError);
    CHECK_THROWS_WITH(Job(scene),
                      terravox::test::contains("voxel (60, 3, 60) is solid") &&
                          terravox::test::contains("m higher, or --camera-inside-rock yes"));
    scene.camera.inside_rock = true;
    CHECK_NOTHROW(Job(scene));
    scene.camera.inside_rock = false;
    scene.camera.position = {1e10, 0, 0};
    CHECK_THROWS_AS(Job(scene), util::UsageError);
}

TEST_CASE("a level that the world does not have is refused", "[raytracer][render]") {
    scene::Scene scene = small_scene();
    scene.quality.level = 1;
    CHECK_THROWS_WITH(Job(scene),
                      terravox::test::contains("quality.level = 1; this world has 0 to 0"));
}
