#include <cmath>
#include <filesystem>
#include <random>
#include <string>

#include "raytracer/core/scene/scene_io.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

// For all scenes, light is finite and not negative.

using namespace terravox;
using terravox::test::ArrayWorld;
using voxel::Material;

namespace {

constexpr int kScenes = 160;

/// Choices of one scene, by its number alone.
class Chooser {
public:
    explicit Chooser(std::uint64_t seed) : m_random(seed) {}
    /// [low, high)
    double between(double low, double high) {
        return low + (high - low) * static_cast<double>(m_random() >> 11) * 0x1.0p-53;
    }
    /// A uniform number in [low, high].
    int whole(int low, int high) {
        return low + static_cast<int>(m_random() % static_cast<std::uint64_t>(high - low + 1));
    }
    bool one_in(int n) { return m_random() % static_cast<std::uint64_t>(n) == 0; }
    template <class Value>
    Value of(std::initializer_list<Value> values) {
        return values.begin()[m_random() % values.size()];
    }

private:
    std::mt19937_64 m_random;
};

/// Every material, in blocks, over and under a lake.
std::unique_ptr<ArrayWorld> world_of_everything() {
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-24, -12, -24},
                                              ArrayWorld::Coord{24, 20, 24});
    world->fill_with([](int x, int y, int z) {
        const int ground = (x * x - z * z) / 64 + ((x * 5 ^ z * 3) & 3) - 4;
        const auto any = static_cast<Material>(
            1 + ((x >> 1) * 7 + (z >> 1) * 11 + (y >> 1) * 3 + 400) % (voxel::kMaterialCount - 1));
        if (y < ground)
            return y + 2 < ground ? Material::kRock : any;
        if (y < 0)
            return Material::kWater;
        return ((x >> 2) * 3 + (z >> 2) * 5 + 100) % 7 == 0 && y < 9 ? any : Material::kAir;
    });
    return world;
}

/// Looks at the ends of their ranges.
material::MaterialAppearances strange_appearances(Chooser& choose) {
    material::MaterialAppearances out =
        material::read_materials(std::filesystem::path(TERRAVOX_SOURCE_DIR) /
                                 "config/materials.toml")
            .appearances;
    for (material::MaterialAppearance& appearance : out) {
        if (choose.one_in(2))
            continue;
        appearance.kind = choose.of({material::Kind::kSolid, material::Kind::kLeaves,
                                     material::Kind::kWater, material::Kind::kGlass});
        const auto colour = [&](double most) {
            const double r = choose.between(0, most);
            const double g = choose.of({0.0, most});
            const double b = choose.between(0, most);
            return voxel::Colour{static_cast<float>(r), static_cast<float>(g),
                                 static_cast<float>(b)};
        };
        appearance.colour = colour(1);
        appearance.variation = choose.of({0.0f, 0.3f, 1.0f});
        appearance.roughness = choose.of({0.0f, 1e-4f, 0.3f, 1.0f});
        appearance.index = choose.of({1.0f, 1.0001f, 1.333f, 4.0f});
        appearance.absorption_per_m = colour(choose.of({0.0, 1.0, 1000.0}));
        appearance.glow = colour(1);
        appearance.emission = colour(choose.of({0.0, 1.0, 1000.0}));
        appearance.reflects = choose.one_in(3);
    }
    return out;
}

void choose_camera(Chooser& choose, scene::Scene& scene) {
    auto& camera = scene.camera;
    camera.projection = choose.of<core::CameraProjection>(
        {core::CameraProjection::kPerspective, core::CameraProjection::kPerspective,
         core::CameraProjection::kOrthographic, core::CameraProjection::kIsometric,
         core::CameraProjection::kPanorama, core::CameraProjection::kFisheye});
    camera.fov_deg = camera.projection == core::CameraProjection::kFisheye
                         ? choose.of({1.0, 180.0, 360.0})
                         : choose.of({1.0, 40.0, 90.0, 170.0});
    camera.space = core::CoordinateSpace::kVoxel;
    camera.inside_rock = true;
    const bool flat = camera.projection != core::CameraProjection::kPanorama &&
                      camera.projection != core::CameraProjection::kFisheye;
    if (flat && choose.one_in(3)) {
        camera.aperture_m = choose.of({0.01, 1.0, 8.0});
        camera.focus_m = choose.of({0.001, 5.0, 1e6});
    }
    if (camera.projection != core::CameraProjection::kPanorama && choose.one_in(4))
        camera.roll_deg = choose.between(-180, 180);
    camera.azimuth_deg = choose.of({0.0, 90.0, 225.0, 359.0});
    camera.down_deg = choose.of({-30.0, 0.0, 35.0, 90.0});
    if (choose.one_in(4))
        return;
    // On corners and planes of the grid as well as anywhere; in the air, in the lake, in rock.
    const auto place = [&](int low, int high) {
        return choose.one_in(2) ? choose.whole(low, high) : choose.between(low, high);
    };
    const std::array<double, 3> at = {place(-30, 30), place(-10, 30), place(-30, 30)};
    std::array<double, 3> target = {place(-20, 20), place(-9, 10), place(-20, 20)};
    if (choose.one_in(3)) {  // along an axis, also straight down and up
        target = at;
        target[static_cast<std::size_t>(choose.whole(0, 2))] += choose.of({-7.0, 7.0});
    }
    if (at != target) {
        camera.position = at;
        camera.target = target;
    }
}

void choose_light(Chooser& choose, scene::Scene& scene) {
    scene.sun.altitude_deg = choose.of({-90.0, -18.0, -4.0, -0.3, -0.001, 0.0, 0.001, 0.26, 5.0,
                                        45.0, 90.0, choose.between(-90, 90)});
    scene.sun.azimuth_deg = choose.of({0.0, 90.0, 180.0, 270.0, choose.between(-360, 360)});
    scene.sun.size = choose.of({0.0, 1.0, 1.0, 20.0, 100.0});
    scene.sun.strength = choose.of({0.0, 1.0, 1.0, 100.0});
    if (choose.one_in(4))
        scene.sun.light = std::array<double, 3>{choose.of({0.0, 1e6}), 1, choose.between(0, 3)};
    scene.sky.model = choose.of<core::SkyModel>(
        {core::SkyModel::kAtmosphere, core::SkyModel::kAtmosphere, core::SkyModel::kUniform});
    if (choose.one_in(2))
        scene.sky.colour = std::array<double, 3>{choose.of({0.0, 1e6}), 0, choose.between(0, 2)};
    scene.sky.turbidity = choose.of({1.5, 2.5, 10.0});
    scene.sky.clouds = choose.of({0.0, 0.0, 0.4, 1.0});
    scene.sky.cloud_height_m = choose.of({100.0, 1500.0, 12000.0});
    scene.sky.strength = choose.of({0.0, 1.0, 1.0, 100.0});
    if (choose.one_in(3))
        scene.sky.visibility_km = choose.of({0.0, 1e-3, 10.0, 1e5});
}

void choose_quality(Chooser& choose, scene::Scene& scene) {
    auto& q = scene.quality;
    q.integrator = choose.of({core::Integrator::kDirect, core::Integrator::kPath});
    q.samples = choose.whole(1, 3);
    q.seed = choose.whole(0, 1000);
    q.bounces = choose.of({0, 1, 3, 8, 64});
    q.clamp = choose.of({0.0, 1e-3, 16.0});
    q.ao_rays = choose.of({0, 1, 3});
    q.ao_range_m = choose.of({0.01, 4.0, 1e6});
    q.ao_strength = choose.of({0.0, 0.5, 1.0});
    for (bool* flag : {&q.shadows, &q.ambient_occlusion, &q.reflections, &q.refraction, &q.textures,
                       &q.cut_outs})
        *flag = !choose.one_in(4);
    q.colour = choose.of(
        {core::VoxelColour::kMaterial, core::VoxelColour::kTrue, core::VoxelColour::kMix});
    q.coarse_step = choose.of({1, 4});
    scene.output.exposure_ev = choose.of({-20.0, 0.0, 20.0});
    scene.output.adaptation = choose.of({0.0, 0.75, 1.0});
}

scene::Scene random_scene(Chooser& choose) {
    scene::Scene scene;
    scene.output.size_px = {choose.whole(1, 24), choose.whole(1, 16)};
    scene.output.layers = core::PictureLayers::kAll;
    choose_camera(choose, scene);
    choose_light(choose, scene);
    choose_quality(choose, scene);
    return scene;
}

bool is_light(voxel::Colour c) {
    return std::isfinite(c.r) && std::isfinite(c.g) && std::isfinite(c.b) && c.r >= 0 && c.g >= 0 &&
           c.b >= 0;
}
bool is_share(float v) {
    return v >= 0 && v <= 1.0001f;
}
std::string text(voxel::Colour c) {
    return std::to_string(c.r) + " " + std::to_string(c.g) + " " + std::to_string(c.b);
}

/// What is wrong with a pixel; empty: nothing.
std::string describe_fault(const tiles::PixelSample& p, const tiles::LayerSample& l) {
    if (!is_light(p.colour))
        return "colour " + text(p.colour);
    if (!is_light(l.direct))
        return "direct " + text(l.direct);
    if (!is_light(l.indirect))
        return "indirect " + text(l.indirect);
    if (!is_light(l.albedo))
        return "albedo " + text(l.albedo);
    if (!(std::isfinite(p.error) && p.error >= 0))
        return "error " + std::to_string(p.error);
    if (!is_share(p.alpha))
        return "alpha " + std::to_string(p.alpha);
    if (!(p.depth_m >= 0 && (std::isfinite(p.depth_m) || p.alpha == 0)))
        return "depth " + std::to_string(p.depth_m) + " at alpha " + std::to_string(p.alpha);
    if (!is_share(l.sun) || !is_share(l.water))
        return "sun " + std::to_string(l.sun) + ", water " + std::to_string(l.water);
    double length2 = 0;
    for (const float n : l.normal)
        length2 += static_cast<double>(n) * static_cast<double>(n);
    if (!(length2 < 1.001))
        return "normal of squared length " + std::to_string(length2);
    for (const float at : l.position)
        if (!std::isfinite(at))
            return "position " + std::to_string(at);
    for (const tiles::Matte* matte : {&l.materials, &l.squares})
        for (const float share : matte->share)
            if (!is_share(share))
                return "share of a matte " + std::to_string(share);
    return {};
}

/// The first fault of the picture; empty: none.
std::string fault_of_picture(const scene::Scene& scene, Chooser& choose) {
    auto world = world_of_everything();
    world->editable_info().voxel_m = choose.of({0.25, 1.0, 1.0, 8.0});
    test::Job job(scene, std::size_t{64} << 20, std::move(world));
    if (choose.one_in(2))
        job.view.materials = std::make_shared<material::MaterialTable>(strange_appearances(choose));
    const output::Film film = test::render_scene(job, 1);
    for (int y = 0; y < film.height_px(); ++y)
        for (int x = 0; x < film.width_px(); ++x) {
            const std::string fault = describe_fault(film.at(x, y), film.layers_at(x, y));
            if (!fault.empty())
                return "pixel " + std::to_string(x) + ", " + std::to_string(y) + ": " + fault;
        }
    return {};
}

}  // namespace

TEST_CASE("in any scene every value of every layer is a number, and no light is less than nothing",
          "[raytracer][shade][light][finite][all]") {
    for (int number = 0; number < kScenes; ++number) {
        Chooser choose(static_cast<std::uint64_t>(number) + 1);
        const scene::Scene scene = random_scene(choose);
        INFO("scene " << number << ":\n" << scene::to_toml(scene));
        CHECK(fault_of_picture(scene, choose) == "");
    }
}
