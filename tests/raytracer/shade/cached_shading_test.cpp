#include <cmath>

#include "raytracer/shade/view_maker.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"
#include "tests/raytracer/pyramid_world.hpp"

// Light kept by face against paths, and against what must not change it.

using namespace terravox;
using terravox::test::ArrayWorld;
using voxel::Material;

namespace {

scene::Scene cached_scene() {
    scene::Scene scene = test::small_scene();
    scene.output.size_px = {48, 27};
    scene.quality.integrator = core::Integrator::kCached;
    return scene;
}

output::Film film_of(const scene::Scene& scene, shade::ViewMaker& maker,
                     blocks::BlockManager& blocks) {
    const shade::View view = maker.make(scene, blocks);
    const auto [width, height] = scene.output.size_px;
    output::Film film(width, height, view.wants_layers());
    processors::ThreadProcessor processor(view, blocks, 2);
    (void)render::render_film({view, processor, true, {}}, film);
    return film;
}

std::string picture(const scene::Scene& scene, shade::ViewMaker& maker,
                    blocks::BlockManager& blocks) {
    return test::bytes_of(film_of(scene, maker, blocks));
}

/// Mean light of all pixels over pictures of several seeds.
double mean_light(scene::Scene scene, int seeds) {
    double sum = 0;
    std::size_t pixels = 0;
    for (int seed = 0; seed < seeds; ++seed) {
        scene.quality.seed = seed;
        test::Job job(scene);
        const output::Film film = test::render_scene(job, 2);
        for (const tiles::PixelSample& p : film.samples())
            sum += static_cast<double>(voxel::luminance(p.colour));
        pixels += film.samples().size();
    }
    return sum / static_cast<double>(pixels);
}

/// Of a picture of a world that also has coarser levels.
double brightest(const scene::Scene& scene, std::unique_ptr<ArrayWorld> finest, int levels) {
    test::PyramidWorld world(std::move(finest), levels);
    blocks::BlockManager blocks(world, std::size_t{256} << 20);
    shade::ViewMaker maker;
    const output::Film film = film_of(scene, maker, blocks);
    double out = 0;
    for (const tiles::PixelSample& p : film.samples())
        out = std::max(out, static_cast<double>(voxel::luminance(p.colour)));
    return out;
}

/// A closed box in the sun. Its walls and its roof are one voxel thick.
std::unique_ptr<ArrayWorld> closed_box() {
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-64, -8, -64},
                                              ArrayWorld::Coord{64, 40, 64});
    world->fill({-64, -8, -64}, {64, 0, 64}, Material::kRock);
    world->fill({-9, 0, -9}, {10, 12, 10}, Material::kConcrete);
    world->fill({-8, 0, -8}, {9, 11, 9}, Material::kAir);
    world->editable_info().bounds = world->level_bounds();
    return world;
}

}  // namespace

TEST_CASE("kept light has the mean of paths", "[raytracer][shade][light][cached]") {
    scene::Scene scene = cached_scene();
    scene.quality.samples = 16;
    scene.quality.clamp = 0;
    const double cached = mean_light(scene, 4);
    scene.quality.integrator = core::Integrator::kPath;
    scene.quality.samples = 64;
    const double path = mean_light(scene, 4);
    INFO("cached " << cached << ", paths " << path);
    CHECK(cached == Approx(path).epsilon(0.01));
}

TEST_CASE("no light leaks through walls and a roof of one voxel",
          "[raytracer][shade][light][cached]") {
    scene::Scene scene = cached_scene();
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.camera.position = {-7.5, 9.5, -7.5};
    scene.camera.target = {8, 0, 8};
    scene.camera.fov_deg = 100;
    scene.sky.visibility_km = 0;
    for (const int levels : {1, 4}) {
        INFO(levels << " levels");
        CHECK(brightest(scene, closed_box(), levels) == 0);
        // The same place without its roof is not black.
        auto open = closed_box();
        open->fill({-8, 11, -8}, {9, 12, 9}, Material::kAir);
        CHECK(brightest(scene, std::move(open), levels) > 0.01);
    }
}

TEST_CASE("a picture does not depend on what is kept already, nor on how much may be kept",
          "[raytracer][shade][light][cached][deterministic]") {
    const auto world = test::landscape();
    blocks::BlockManager blocks(*world, std::size_t{256} << 20);
    scene::Scene first = cached_scene();
    first.quality.gather_rays = 8;
    scene::Scene second = first;
    second.camera.azimuth_deg = 215;
    second.camera.zoom = 1.7;
    scene::Scene little = second;
    little.processing.light_mib = 1;
    shade::ViewMaker fresh;
    const std::string reference = picture(second, fresh, blocks);
    shade::ViewMaker shared;
    (void)picture(first, shared, blocks);
    CHECK((picture(second, shared, blocks) == reference));
    shade::ViewMaker small;
    CHECK((picture(little, small, blocks) == reference));
}

TEST_CASE("light is kept from view to view until something that it depends on changes",
          "[raytracer][shade][light][cached]") {
    const auto world = test::landscape();
    blocks::BlockManager blocks(*world, std::size_t{256} << 20);
    const scene::Scene scene = cached_scene();
    shade::ViewMaker maker;
    const auto kept = maker.make(scene, blocks).kept_light;
    REQUIRE(kept);
    struct Case {
        const char* name;
        void (*set)(scene::Scene&);
        bool same;
    };
    const Case cases[] = {
        {"the camera moves", [](scene::Scene& s) { s.camera.azimuth_deg = 10; }, true},
        {"more samples", [](scene::Scene& s) { s.quality.samples = 9; }, true},
        {"a larger picture", [](scene::Scene& s) { s.output.size_px = {100, 80}; }, true},
        {"the sun moves", [](scene::Scene& s) { s.sun.azimuth_deg = 241; }, false},
        {"a hazier sky", [](scene::Scene& s) { s.sky.turbidity = 4; }, false},
        {"fewer bounces", [](scene::Scene& s) { s.quality.bounces = 2; }, false},
        {"more gather rays", [](scene::Scene& s) { s.quality.gather_rays = 17; }, false},
        {"other colours", [](scene::Scene& s) { s.quality.colour = core::VoxelColour::kMaterial; },
         false},
    };
    for (const Case& c : cases) {
        shade::ViewMaker again = maker;
        scene::Scene changed = scene;
        c.set(changed);
        INFO(c.name);
        CHECK((again.make(changed, blocks).kept_light == kept) == c.same);
    }
    scene::Scene path = scene;
    path.quality.integrator = core::Integrator::kPath;
    CHECK_FALSE(maker.make(path, blocks).kept_light);
}
