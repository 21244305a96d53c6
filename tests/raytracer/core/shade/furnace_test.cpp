#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>

#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"
#include "tests/raytracer/scene_words_text.hpp"

// Light against what can be worked out by hand: a furnace, a closed box, a plane, a corner.

using namespace terravox;
using terravox::test::ArrayWorld;
using voxel::Material;

namespace {

constexpr int kManyBounces = 250;  // no path of these worlds has more that count
using MaterialAppearances = material::MaterialAppearances;

MaterialAppearances matt(float albedo) {
    material::MaterialAppearance appearance;
    appearance.colour = {albedo, albedo, albedo};
    MaterialAppearances out;
    out.fill(appearance);
    return out;
}

/// A clear pool's water, or ice: it takes nothing from the light.
material::MaterialAppearance clear(material::Kind kind, float index) {
    material::MaterialAppearance appearance;
    appearance.kind = kind;
    appearance.colour = {1, 1, 1};
    appearance.index = index;
    appearance.roughness = 0;
    return appearance;
}

scene::Scene make_scene(core::Integrator integrator, int samples, std::array<double, 3> eye,
                        std::array<double, 3> target) {
    scene::Scene scene;
    scene.output.size_px = {48, 32};
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.camera.position = eye;
    scene.camera.target = target;
    scene.sky.model = core::SkyModel::kUniform;
    scene.sun.strength = 0;
    scene.sun.altitude_deg = 40;
    scene.sun.azimuth_deg = 130;
    scene.quality.integrator = integrator;
    scene.quality.samples = samples;
    scene.quality.bounces = kManyBounces;
    scene.quality.clamp = 0;
    scene.quality.textures = false;
    scene.quality.coarse_step = 1;
    return scene;
}

struct Mean {
    double light = 0;  ///< luminance of the pixels that show a voxel and nothing else
    int pixels = 0;
    double least = 1e9;
    double most = 0;
};
Mean measure_mean(const output::Film& film) {
    Mean out;
    for (const tiles::PixelSample& p : film.samples()) {
        if (p.alpha < 1)
            continue;
        const auto light = static_cast<double>(voxel::luminance(p.colour));
        out.light += light;
        ++out.pixels;
        out.least = std::min(out.least, light);
        out.most = std::max(out.most, light);
    }
    out.light /= std::max(out.pixels, 1);
    return out;
}

Mean make_light(const scene::Scene& scene, std::unique_ptr<ArrayWorld> world,
                const MaterialAppearances& appearances) {
    world->editable_info().bounds = world->level_bounds();
    test::Job job(scene, std::size_t{256} << 20, std::move(world));
    job.view.materials = std::make_shared<material::MaterialTable>(appearances);
    return measure_mean(test::render_scene(job, 2));
}

/// Pillars of all heights, an overhanging deck, a pit and a tunnel, on a plain; water in a basin,
/// and a block of it that stands by itself.
std::unique_ptr<ArrayWorld> furnace_world() {
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-40, -12, -40},
                                              ArrayWorld::Coord{40, 24, 40});
    world->fill({-40, -12, -40}, {40, 0, 40}, Material::kRock);
    for (int x = -20; x < 20; x += 5)
        for (int z = -20; z < 20; z += 4)
            world->fill({x, 0, z}, {x + 1 + (x & 1), 2 + ((x * 7 + z * 3) & 7), z + 2},
                        Material::kWall);
    world->fill({-18, 9, -14}, {-2, 11, 6}, Material::kConcrete);
    world->fill({4, -6, 4}, {12, 0, 12}, Material::kAir);
    world->fill({12, -6, 6}, {30, -3, 8}, Material::kAir);
    world->fill({-30, -8, 8}, {-4, 0, 30}, Material::kAir);
    world->fill({-30, -8, 8}, {-4, -1, 30}, Material::kWater);
    world->fill({4, 0, -12}, {9, 6, -6}, Material::kWater);
    return world;
}

std::unique_ptr<ArrayWorld> plane() {
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-40, -4, -40},
                                              ArrayWorld::Coord{40, 12, 40});
    world->fill({-40, -4, -40}, {40, 0, 40}, Material::kRock);
    return world;
}

/// Looks at a spot on the plane, steeply.
scene::Scene spot_scene(core::Integrator integrator, int samples, double x, double z) {
    scene::Scene scene = make_scene(integrator, samples, {x + 0.3, 11, z + 0.2}, {x, 0, z});
    scene.output.size_px = {4, 4};
    scene.camera.fov_deg = 1;
    return scene;
}

/// Share of the light on a small level face that a wall keeps from it: the wall stands on the
/// face's plane, and one of its lower corners is nearest. Ref: Howell, "A Catalog of Radiation Heat
/// Transfer Configuration Factors", plane element to a rectangle at right angles.
double kept_by_wall(double distance, double width, double height) {
    const double x = height / width;
    const double y = distance / width;
    const double r = std::sqrt(x * x + y * y);
    return (std::atan(1 / y) - y / r * std::atan(1 / r)) / (2 * std::numbers::pi);
}

}  // namespace

TEST_CASE("in a furnace of white things everything is as bright as the sky",
          "[raytracer][shade][light][furnace]") {
    struct Case {
        const char* name;
        std::function<void(MaterialAppearances&, scene::Scene&)> set;
    };
    const auto number = [](Material m) { return static_cast<std::size_t>(m); };
    const Case cases[] = {
        {"matt", [](MaterialAppearances&, scene::Scene&) {}},
        {"matt, with water that takes nothing",
         [&](MaterialAppearances& l, scene::Scene&) {
             l[number(Material::kWater)] = clear(material::Kind::kWater, 1.333f);
         }},
        {"the same with waves",
         [&](MaterialAppearances& l, scene::Scene& s) {
             s.quality.textures = true;
             material::MaterialAppearance water =
                 material::read_materials(std::filesystem::path(TERRAVOX_SOURCE_DIR) /
                                          "config/materials.toml")
                     .appearances[number(Material::kWater)];
             water.absorption_per_m = water.glow = {};
             water.colour = {1, 1, 1};
             l[number(Material::kWater)] = water;
         }},
        {"matt, with ice",
         [&](MaterialAppearances& l, scene::Scene&) {
             l[number(Material::kWater)] = clear(material::Kind::kGlass, 1.31f);
         }},
        {"varnished and rough mirrors",
         [&](MaterialAppearances& l, scene::Scene&) {
             for (const Material m : {Material::kWall, Material::kConcrete}) {
                 l[number(m)].reflects = true;
                 l[number(m)].roughness = 0.4f;
             }
             l[number(Material::kRock)].reflects = true;
             l[number(Material::kRock)].roughness = 0;
         }},
        {"seen from under water",
         [&](MaterialAppearances& l, scene::Scene& s) {
             l[number(Material::kWater)] = clear(material::Kind::kWater, 1.333f);
             s.camera.position = {{-17.3, -4.4, 18.2}};
             s.camera.target = {{-10, -4, 40}};
             s.camera.inside_rock = true;
         }},
    };
    for (const Case& c : cases) {
        MaterialAppearances appearances = matt(1);
        scene::Scene scene = make_scene(core::Integrator::kPath, 16, {-38, 22, 39}, {0, -2, 0});
        scene.camera.fov_deg = 60;
        c.set(appearances, scene);
        const Mean found = make_light(scene, furnace_world(), appearances);
        INFO(c.name << ": " << found.pixels << " pixels from " << found.least << " to "
                    << found.most);
        REQUIRE(found.pixels > 400);
        CHECK(found.light == Approx(1).epsilon(0.01));
    }
}

TEST_CASE("in a closed box that glows, light is its own over what is lost at each meeting",
          "[raytracer][shade][light][furnace]") {
    struct Case {
        float albedo;
        float emission;
    };
    for (const Case& c : {Case{0.5f, 0.25f}, {0.9f, 0.1f}, {0.2f, 3}}) {
        MaterialAppearances appearances = matt(c.albedo);
        for (material::MaterialAppearance& appearance : appearances)
            appearance.emission = {c.emission, c.emission, c.emission};
        auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-12, -8, -10},
                                                  ArrayWorld::Coord{12, 8, 10});
        world->fill({-12, -8, -10}, {12, 8, 10}, Material::kConcrete);
        world->fill({-10, -6, -8}, {10, 6, 8}, Material::kAir);
        world->fill({-2, -6, -2}, {3, 1, 2}, Material::kConcrete);
        const Mean found =
            make_light(make_scene(core::Integrator::kPath, 16, {-8, 4, 6}, {0, -2, 0}),
                       std::move(world), appearances);
        const double expected =
            static_cast<double>(c.emission) / (1 - static_cast<double>(c.albedo));
        INFO("albedo " << c.albedo << ", emission " << c.emission << ": " << found.least << " to "
                       << found.most);
        REQUIRE(found.pixels == 48 * 32);
        CHECK(found.light == Approx(expected).epsilon(0.01));
    }
}

TEST_CASE("a plane in the sun alone sends its albedo times the sun's sine of altitude",
          "[raytracer][shade][light][furnace]") {
    for (const core::Integrator integrator : {core::Integrator::kDirect, core::Integrator::kPath})
        for (const double size : {0.0, 1.0})
            for (const double altitude_deg : {4.0, 30.0, 90.0}) {
                scene::Scene scene = spot_scene(integrator, 64, 0, 0);
                scene.sky.strength = 0;
                scene.sun.strength = 1;
                scene.sun.size = size;
                scene.sun.altitude_deg = altitude_deg;
                scene.sun.light = {{1.5, 1.5, 1.5}};
                const Mean found = make_light(scene, plane(), matt(0.6f));
                INFO(integrator << ", size " << size << ", altitude " << altitude_deg);
                CHECK(found.light ==
                      Approx(0.6 * 1.5 * std::sin(altitude_deg * std::numbers::pi / 180))
                          .epsilon(0.002));
            }
}

TEST_CASE(
    "under the sky of the atmosphere paths bring a plane what its table of ambient light says",
    "[raytracer][shade][light][furnace]") {
    for (const double altitude_deg : {60.0, 8.0}) {
        scene::Scene scene = spot_scene(core::Integrator::kPath, 1024, 0, 0);
        scene.sky.model = core::SkyModel::kAtmosphere;
        scene.sky.visibility_km = 0;
        scene.sun.altitude_deg = altitude_deg;
        const Mean path = make_light(scene, plane(), matt(0.5f));
        scene.quality.integrator = core::Integrator::kDirect;
        scene.quality.ambient_occlusion = false;
        scene.quality.samples = 4;
        const Mean table = make_light(scene, plane(), matt(0.5f));
        INFO("altitude " << altitude_deg);
        CHECK(path.light == Approx(table.light).epsilon(0.01));
    }
}

TEST_CASE("on a floor in a corner of two walls the sky's light is the share that they leave open",
          "[raytracer][shade][light][furnace]") {
    struct Case {
        double x, z;  ///< the walls' feet are x = 0 and z = 0
    };
    constexpr double kLong = 30;
    constexpr double kHigh = 9;
    for (const Case& c : {Case{1.5, 2.5}, {6.5, 0.4}, {12, 15}}) {
        // Each wall in two parts, on both sides of the foot of the perpendicular.
        const auto kept_by = [](double distance, double along) {
            return kept_by_wall(distance, along, kHigh) +
                   kept_by_wall(distance, kLong - along, kHigh);
        };
        const double kept = kept_by(c.x, c.z) + kept_by(c.z, c.x);
        for (const core::Integrator integrator :
             {core::Integrator::kDirect, core::Integrator::kPath}) {
            auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-4, -4, -4},
                                                      ArrayWorld::Coord{40, 16, 40});
            world->fill({-4, -4, -4}, {40, 0, 40}, Material::kGround);
            world->fill({-2, 0, 0}, {0, 9, 30}, Material::kRock);
            world->fill({0, 0, -2}, {30, 9, 0}, Material::kRock);
            MaterialAppearances appearances = matt(0.8f);
            appearances[static_cast<std::size_t>(Material::kRock)]
                .colour = {};  // what the walls throw back is no light of the sky
            scene::Scene scene = spot_scene(integrator, 1024, c.x, c.z);
            scene.quality.ao_rays = 4;
            scene.quality.ao_range_m = 1000;
            const Mean found = make_light(scene, std::move(world), appearances);
            INFO(integrator << " at " << c.x << ", " << c.z << ", open " << 1 - kept);
            CHECK(found.light == Approx(0.8 * (1 - kept)).epsilon(0.01));
        }
    }
}

TEST_CASE(
    "a bed under still water sends up what absorption and both ways through the surface leave",
    "[raytracer][shade][light][furnace]") {
    constexpr double kIndex = 1.333;
    constexpr double kAbsorption_per_m = 0.2;
    constexpr double kDepth_m = 3;
    constexpr double kAlbedo = 0.6;
    constexpr double kSun = 1.5;
    constexpr double kGlow = 0.7;
    const auto left = [](double way_m) { return std::exp(-kAbsorption_per_m * way_m); };
    const double mirrored =
        (kIndex - 1) / (kIndex + 1) * ((kIndex - 1) / (kIndex + 1));  // for perpendicular light
    const double up = (1 - mirrored) * left(kDepth_m);
    struct Case {
        core::Integrator integrator;
        double altitude_deg;  ///< of the sun; 0: there is none, and the bed glows
    };
    for (const Case& c : {Case{core::Integrator::kDirect, 0},
                          {core::Integrator::kPath, 0},
                          {core::Integrator::kDirect, 60},
                          {core::Integrator::kPath, 60},
                          {core::Integrator::kDirect, 12},
                          {core::Integrator::kPath, 12}}) {
        MaterialAppearances appearances = matt(static_cast<float>(kAlbedo));
        material::MaterialAppearance water =
            clear(material::Kind::kWater, static_cast<float>(kIndex));
        water.absorption_per_m = voxel::Colour{1, 1, 1} * static_cast<float>(kAbsorption_per_m);
        appearances[static_cast<std::size_t>(Material::kWater)] = water;
        double expected = kGlow * up;
        // One bounce lets light into the water and out of it, and takes none from bed to bed by way
        // of the surface.
        scene::Scene scene = spot_scene(c.integrator, 256, 0.4, 0.3);
        scene.quality.bounces = 1;
        scene.sky.strength = 0;
        scene.camera.position = {{0.4, 11, 0.301}};
        if (c.altitude_deg > 0) {
            scene.sun.strength = 1;
            scene.sun.altitude_deg = c.altitude_deg;
            scene.sun.light = {{kSun, kSun, kSun}};
            const double sin = std::sin(c.altitude_deg * std::numbers::pi / 180);
            const double sin_in = std::cos(c.altitude_deg * std::numbers::pi / 180) / kIndex;
            const double cos_in = std::sqrt(1 - sin_in * sin_in);
            const double s = (sin - kIndex * cos_in) / (sin + kIndex * cos_in);
            const double p = (kIndex * sin - cos_in) / (kIndex * sin + cos_in);
            expected =
                kAlbedo * kSun * sin * (1 - (s * s + p * p) / 2) * left(kDepth_m / cos_in) * up;
        } else {
            appearances[static_cast<std::size_t>(Material::kRock)].emission =
                voxel::Colour{1, 1, 1} * static_cast<float>(kGlow);
        }
        auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-40, -8, -40},
                                                  ArrayWorld::Coord{40, 12, 40});
        world->fill({-40, -8, -40}, {40, -3, 40}, Material::kRock);
        world->fill({-40, -3, -40}, {40, 0, 40}, Material::kWater);
        const Mean found = make_light(scene, std::move(world), appearances);
        INFO(c.integrator << ", sun at " << c.altitude_deg);
        CHECK(found.light == Approx(expected).epsilon(0.005));
    }
}
