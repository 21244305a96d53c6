#include <cmath>
#include <numbers>

#include "raytracer/core/walk/lamp_query.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

// Lamps: which are near, and their light against closed forms and against paths that meet them by
// chance.

using namespace terravox;
using terravox::test::ArrayWorld;
using voxel::Material;

namespace {

constexpr float kAlbedo = 0.5f;
constexpr float kLampLight = 2;

std::shared_ptr<const material::MaterialTable> grey_with_lamps() {
    material::MaterialAppearances appearances;
    material::MaterialAppearance grey;
    grey.colour = {kAlbedo, kAlbedo, kAlbedo};
    appearances.fill(grey);
    appearances[static_cast<std::size_t>(Material::kLamp)].emission = {kLampLight, kLampLight,
                                                                       kLampLight};
    return std::make_shared<material::MaterialTable>(appearances);
}

scene::Scene night_scene(core::Integrator integrator, int samples) {
    scene::Scene scene;
    scene.output.size_px = {32, 24};
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.sun.altitude_deg = -40;
    scene.sun.azimuth_deg = 130;
    scene.sky.model = core::SkyModel::kUniform;
    scene.sky.strength = 0;
    scene.quality.integrator = integrator;
    scene.quality.samples = samples;
    scene.quality.bounces = 4;
    scene.quality.clamp = 0;
    scene.quality.textures = false;
    scene.quality.coarse_step = 1;
    return scene;
}

/// A street with houses at its sides and lamps on posts, on the ground and on walls, in several
/// boxes.
std::unique_ptr<ArrayWorld> lamp_street() {
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-70, -3, -70},
                                              ArrayWorld::Coord{70, 20, 70});
    world->fill({-70, -3, -70}, {70, 0, 70}, Material::kRock);
    for (int x = -68; x < 68; x += 17) {
        world->fill({x, 0, -9}, {x + 11, 8, -4}, Material::kWall);
        world->fill({x + 2, 0, 5}, {x + 13, 6, 11}, Material::kWall);
        world->fill({x, 0, 2}, {x + 1, 4, 3}, Material::kWall);
        world->fill({x, 4, 2}, {x + 1, 5, 3}, Material::kLamp);
        world->fill({x + 7, 0, -2}, {x + 9, 1, -1}, Material::kLamp);
        world->fill({x + 4, 3, -4}, {x + 5, 4, -3}, Material::kLamp);
    }
    world->editable_info().bounds = world->level_bounds();
    return world;
}

std::unique_ptr<ArrayWorld> lamp_above_plane(int height) {
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-40, -4, -40},
                                              ArrayWorld::Coord{40, 24, 40});
    world->fill({-40, -4, -40}, {40, 0, 40}, Material::kRock);
    world->fill({0, height, 0}, {1, height + 1, 1}, Material::kLamp);
    world->editable_info().bounds = world->level_bounds();
    return world;
}

scene::Scene street_scene(core::Integrator integrator, int samples) {
    scene::Scene scene = night_scene(integrator, samples);
    scene.camera.position = {-30, 3, 0.5};
    scene.camera.target = {20, 1, 0.2};
    scene.camera.fov_deg = 70;
    return scene;
}

/// @param sampled whether lamps are sampled, as at night, or met by chance alone
output::Film lamp_film(const scene::Scene& scene, std::unique_ptr<ArrayWorld> world, bool sampled) {
    test::Job job(scene, std::size_t{256} << 20, std::move(world));
    job.view.materials = grey_with_lamps();
    REQUIRE(job.view.lamps);
    job.view.lamps = sampled;
    return test::render_scene(job, 2);
}

struct Brightness {
    double mean = 0;
    /// Standard deviation of a pixel that shows no lamp about that of a converged picture.
    double spread = 0;
};
Brightness measure_brightness(const output::Film& film, const output::Film* converged = nullptr) {
    Brightness out;
    constexpr double kBrightestFace = 0.25 * kLampLight;
    const auto make_light = [](const tiles::PixelSample& pixel) {
        return static_cast<double>(voxel::luminance(pixel.colour));
    };
    std::size_t i = 0;
    std::size_t faces = 0;
    for (const tiles::PixelSample& pixel : film.samples()) {
        const double light = make_light(pixel);
        const double truth = converged != nullptr ? make_light(converged->samples()[i]) : light;
        ++i;
        out.mean += light;
        if (truth > kBrightestFace)
            continue;
        ++faces;
        out.spread += (light - truth) * (light - truth);
    }
    out.mean /= static_cast<double>(i);
    out.spread = std::sqrt(out.spread / static_cast<double>(faces));
    return out;
}

/// Share of what a small face sees of the lower side of a cube of edge 1, which is centred above
/// it. Ref: Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", plane element to
/// a parallel rectangle.
double seen_from_below(double distance) {
    const double a = 0.5 / distance;
    const double root = std::sqrt(1 + a * a);
    return 4 / (2 * std::numbers::pi) * 2 * a / root * std::atan(a / root);
}

}  // namespace

TEST_CASE("a lamp lights the ground below it as its lower side is seen from there",
          "[raytracer][shade][light][lamp]") {
    for (const core::Integrator integrator : {core::Integrator::kDirect, core::Integrator::kPath})
        for (const int height : {1, 2, 5, 12, 22}) {
            scene::Scene scene = night_scene(integrator, 256);
            scene.quality.ambient_occlusion = false;
            scene.quality.bounces = 1;  // or the lamp would reflect the ground's light
            scene.output.size_px = {8, 8};
            scene.camera.projection = core::CameraProjection::kOrthographic;
            scene.camera.height_m = 0.02;
            scene.camera.position = {30.5, 20.0, 0.5};
            scene.camera.target = {0.5, 0, 0.5};
            const Brightness found =
                measure_brightness(lamp_film(scene, lamp_above_plane(height), true));
            INFO("height " << height << ", integrator " << static_cast<int>(integrator));
            CHECK(found.mean ==
                  Approx(static_cast<double>(kAlbedo * kLampLight) * seen_from_below(height))
                      .epsilon(0.02));
        }
}

TEST_CASE("lamps that are sampled bring the light that paths find by chance, with less noise",
          "[raytracer][shade][light][lamp][all]") {
    const output::Film chance =
        lamp_film(street_scene(core::Integrator::kPath, 4096), lamp_street(), false);
    const output::Film converged =
        lamp_film(street_scene(core::Integrator::kPath, 1024), lamp_street(), true);
    CHECK(measure_brightness(converged).mean ==
          Approx(measure_brightness(chance).mean).epsilon(0.01));

    const Brightness sampled = measure_brightness(
        lamp_film(street_scene(core::Integrator::kPath, 16), lamp_street(), true), &converged);
    const Brightness met = measure_brightness(
        lamp_film(street_scene(core::Integrator::kPath, 16), lamp_street(), false), &converged);
    INFO("noise of sampled lamps " << sampled.spread << ", of lamps by chance " << met.spread);
    CHECK(sampled.spread < 0.55 * met.spread);
}

TEST_CASE("lamps are chosen by their distance, and those behind the face never",
          "[raytracer][walk][lamp]") {
    test::Job job(street_scene(core::Integrator::kPath, 1), std::size_t{256} << 20, lamp_street());
    for (int bx = -2; bx < 2; ++bx)
        for (int bz = -2; bz < 2; ++bz)
            for (int by = -1; by < 1; ++by)
                (void)job.blocks.get({0, bx, by, bz});
    walk::BlockReader reader(job.blocks);
    const walk::LevelCut cut(job.view.cut.bounds(), 0);
    walk::LampQuery query(reader, cut);
    walk::Hit hit;
    hit.voxel = {5, -1, 0};
    hit.face = core::Face::kTop;
    const core::Vec3 point{5.5, 0, 0.5};
    double behind = 0;
    double sum = 0;
    core::VoxelCoord before{1000, 0, 0};
    constexpr int kNumbers = 4000;
    double mean_distance = 0;
    for (int i = 0; i < kNumbers; ++i) {
        walk::LampChoice chosen;
        REQUIRE(query.choose(hit, point, (i + 0.5) / kNumbers, chosen));
        REQUIRE(chosen.probability > 0);
        const core::Vec3 to = chosen.lamp.middle() - point;
        CHECK(core::dot(to, to) <= 64.0 * 64);
        behind += to.y < 0 ? 1 : 0;
        mean_distance += std::sqrt(core::dot(to, to)) / kNumbers;
        if (chosen.lamp.voxel == before)
            continue;
        sum += static_cast<double>(chosen.probability);
        before = chosen.lamp.voxel;
    }
    CHECK(behind == 0);
    // Each lamp fills as much of the numbers as its probability says.
    CHECK(sum == Approx(1).epsilon(0.02));
    CHECK(mean_distance < 20);

    // From below the ground none of them is in front.
    hit.face = core::Face::kBottom;
    walk::LampChoice none;
    REQUIRE(query.choose(hit, {5.5, -1, 0.5}, 0.5, none));
    CHECK(none.looked);
    CHECK(none.probability == 0);
}

TEST_CASE("a box that is not in memory is named, and the choice goes on with it",
          "[raytracer][walk][lamp]") {
    test::Job job(street_scene(core::Integrator::kPath, 1), std::size_t{256} << 20, lamp_street());
    walk::BlockReader reader(job.blocks);
    const walk::LevelCut cut(job.view.cut.bounds(), 0);
    walk::LampQuery query(reader, cut);
    walk::Hit hit;
    hit.voxel = {5, -1, 0};
    hit.face = core::Face::kTop;
    walk::LampChoice chosen;
    std::set<voxel::BoxKey> asked;
    while (!query.choose(hit, {5.5, 0, 0.5}, 0.3, chosen)) {
        REQUIRE(asked.insert(query.missing()).second);
        (void)job.blocks.get(query.missing());
    }
    CHECK(asked.size() >= 4);
    CHECK(chosen.probability > 0);
}

TEST_CASE("where there are very many lamps, none is sampled", "[raytracer][walk][lamp]") {
    for (const bool too_many : {false, true}) {
        auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-64, -1, -64},
                                                  ArrayWorld::Coord{64, 4, 64});
        world->fill({-64, -1, -64}, {64, 0, 64}, Material::kRock);
        // 128 x 128 of them are as many as may be; one more is too many.
        world->fill({-64, 2, -64}, {64, 3, 64}, Material::kLamp);
        if (too_many)
            world->fill({0, 0, 0}, {1, 1, 1}, Material::kLamp);
        world->editable_info().bounds = world->level_bounds();
        test::Job job(street_scene(core::Integrator::kPath, 1), std::size_t{256} << 20,
                      std::move(world));
        walk::BlockReader reader(job.blocks);
        const walk::LevelCut cut(job.view.cut.bounds(), 0);
        walk::LampQuery query(reader, cut);
        walk::Hit hit;
        hit.voxel = {0, -1, 0};
        hit.face = core::Face::kTop;
        walk::LampChoice chosen;
        while (!query.choose(hit, {0.5, 0, 0.5}, 0.3, chosen))
            (void)job.blocks.get(query.missing());
        CHECK(chosen.looked == !too_many);
        CHECK((chosen.probability > 0) == !too_many);
    }
}
