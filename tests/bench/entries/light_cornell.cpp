#include <cstdlib>
#include <fstream>
#include <numbers>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "raytracer/shade/view_maker.hpp"
#include "raytracer/walk/surroundings.hpp"
#include "tests/bench/entries/light_picture.hpp"
#include "tests/common/voxel/array_world.hpp"

namespace terravox::bench::light_cornell_entry {
namespace {

using test::ArrayWorld;
using voxel::Material;

constexpr int kRoom = 32;  // inner edge, voxels
constexpr int kSide_px = 32;
constexpr int kOurSamples = 16384;
constexpr int kTheirSamples = 8192;
constexpr int kBounces = 64;
constexpr double kSunRadius = 4;  // times the true one
constexpr double kTrueSunRadius_rad = 0.2666 * std::numbers::pi / 180;
constexpr std::size_t kBoxMemory_bytes = std::size_t{64} << 20;

/// What the parts of the box are made of.
struct Part {
    Material material;
    voxel::Colour albedo;
    voxel::Colour emission;
};
constexpr voxel::Colour kWhite{0.73f, 0.73f, 0.73f};
constexpr voxel::Colour kDark{};
const std::array kParts = {Part{Material::kConcrete, kWhite, kDark},
                           Part{Material::kOrangeRoof, {0.63f, 0.065f, 0.05f}, kDark},
                           Part{Material::kGrass, {0.14f, 0.45f, 0.091f}, kDark},
                           Part{Material::kTower, {0.5f, 0.5f, 0.5f}, {6, 5, 3.5f}}};

/// A room with a red and a green wall and two blocks. @param roofed with a lamp in its ceiling;
/// else open to the sky
std::unique_ptr<ArrayWorld> room(bool roofed) {
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-1, -1, -1},
                                              ArrayWorld::Coord{kRoom + 1, kRoom + 1, kRoom + 1});
    world->fill({-1, -1, -1}, {kRoom + 1, kRoom + 1, kRoom + 1}, Material::kConcrete);
    world->fill({0, 0, 0}, {kRoom, roofed ? kRoom : kRoom + 1, kRoom}, Material::kAir);
    world->fill({-1, 0, 0}, {0, kRoom, kRoom}, Material::kOrangeRoof);
    world->fill({kRoom, 0, 0}, {kRoom + 1, kRoom, kRoom}, Material::kGrass);
    world->fill({5, 0, 6}, {14, 19, 15}, Material::kConcrete);
    world->fill({18, 0, 14}, {28, 9, 24}, Material::kConcrete);
    if (roofed)
        world->fill({6, kRoom, 6}, {26, kRoom + 1, 26}, Material::kTower);
    world->editable_info().bounds = world->level_bounds();
    return world;
}

/// Every face of a material that borders on air, anticlockwise from outside.
std::vector<float> faces_of(const ArrayWorld& world, Material material) {
    std::vector<float> out;
    const voxel::VoxelBounds& bounds = world.level_bounds();
    const auto add = [&](const core::VoxelCoord& v, core::Face face) {
        const int axis = core::axis_of(face);
        const int a = (axis + 1) % 3;
        const int b = (axis + 2) % 3;
        const bool far = core::sign_of(face) > 0;
        constexpr int kAround[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        for (int i = 0; i < 4; ++i) {
            const auto& corner = kAround[far ? i : 3 - i];
            std::array<float, 3> p{};
            p[static_cast<std::size_t>(axis)] = static_cast<float>(v[axis] + (far ? 1 : 0));
            p[static_cast<std::size_t>(a)] = static_cast<float>(v[a] + corner[0]);
            p[static_cast<std::size_t>(b)] = static_cast<float>(v[b] + corner[1]);
            out.insert(out.end(), p.begin(), p.end());
        }
    };
    for (std::int32_t x = bounds.min[0]; x < bounds.max[0]; ++x)
        for (std::int32_t y = bounds.min[1]; y < bounds.max[1]; ++y)
            for (std::int32_t z = bounds.min[2]; z < bounds.max[2]; ++z) {
                if (world.at(x, y, z) != material)
                    continue;
                for (const core::Face face :
                     {core::Face::kWest, core::Face::kEast, core::Face::kBottom, core::Face::kTop,
                      core::Face::kNorth, core::Face::kSouth}) {
                    const core::VoxelCoord beside = walk::neighbour({x, y, z}, face);
                    if (world.at(beside.x, beside.y, beside.z) == Material::kAir)
                        add({x, y, z}, face);
                }
            }
    return out;
}

/// The camera does not see the lamp: at its edges a pixel's share of it would drown all else.
scene::Scene scene_of(bool roofed) {
    scene::Scene scene;
    scene.output.size_px = {kSide_px, kSide_px};
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.camera.position = {{16, 17, 31.5}};
    scene.camera.target = {{16, 14, 0}};
    scene.camera.fov_deg = 70;
    scene.sky.model = core::SkyModel::kUniform;
    if (roofed) {
        scene.sky.strength = 0;
        scene.sun.strength = 0;
    } else {
        scene.sky.colour = {{0.35, 0.5, 0.8}};
        scene.sun.light = {{2.5, 2.3, 2.0}};
    }
    scene.sun.size = kSunRadius;
    set_sun(scene, core::normalized({0.35, 1, 0.2}));
    scene.quality.integrator = core::Integrator::kPath;
    scene.quality.samples = kOurSamples / 2;
    scene.quality.bounces = kBounces;
    scene.quality.clamp = 0;
    scene.quality.coarse_step = 1;
    scene.quality.textures = false;
    return scene;
}

std::string python() {
    const char* asked = std::getenv("TERRAVOX_PYTHON");
    return asked != nullptr && *asked != '\0' ? asked : "python3";
}

std::string missing(const Context& c) {
    const std::string program = python();
    const bool there =
        c.children.run({program, "-c", "import mitsuba, numpy"}, c.scratch / "mitsuba.txt")
            .exit_code == 0;
    return there ? ""
                 : program + " has no mitsuba with numpy (TERRAVOX_PYTHON names another Python)";
}

std::array<double, 3> numbers(voxel::Colour v) {
    return {static_cast<double>(v.r), static_cast<double>(v.g), static_cast<double>(v.b)};
}

/// The box by the peer.
LinearPicture reference(const Context& c, const ArrayWorld& world, const scene::Scene& scene,
                        bool roofed, Readings& readings) {
    nlohmann::json job = {{"size_px", scene.output.size_px},
                          {"samples", kTheirSamples},
                          {"threads", c.threads},
                          {"seed", 1}};
    for (const Part& part : kParts) {
        const std::vector<float> faces = faces_of(world, part.material);
        if (faces.empty())
            continue;
        const auto file =
            c.scratch / ("cornell-" + std::to_string(static_cast<int>(part.material)) + ".f32");
        std::ofstream(file, std::ios::binary)
            .write(reinterpret_cast<const char*>(faces.data()),
                   static_cast<std::streamsize>(faces.size() * sizeof(float)));
        job["parts"].push_back({{"quads", file.string()},
                                {"albedo", numbers(part.albedo)},
                                {"emission", numbers(part.emission)}});
    }
    job["camera"] = {{"position", *scene.camera.position},
                     {"target", *scene.camera.target},
                     {"fov_deg", scene.camera.fov_deg}};
    job["sky"] = scene.sky.colour.value_or(std::array<double, 3>{});
    if (!roofed)
        job["sun"] = {{"to", {0.35, 1, 0.2}},
                      {"light", *scene.sun.light},
                      {"radius_rad", kSunRadius * kTrueSunRadius_rad}};
    else
        job["sun"] = nullptr;
    const auto picture = c.scratch / "cornell-mitsuba.f32";
    const auto figures = c.scratch / "cornell-figures.json";
    const auto file = c.scratch / "cornell-job.json";
    job["picture"] = picture.string();
    job["figures"] = figures.string();
    util::write_file_atomically(file, job.dump());
    const nlohmann::json found =
        figures_of(c, {python(), "-B", light_script("cornell_mitsuba.py"), file.string()}, figures);
    readings.add("Mitsuba's picture", "s", found.at("wall_s").get<double>());
    return read_picture(picture, kSide_px, kSide_px);
}

void measure(const Context& c, bool roofed, Readings& readings) {
    const auto world = room(roofed);
    blocks::BlockManager blocks(*world, kBoxMemory_bytes);
    material::MaterialAppearances appearances;
    for (const Part& part : kParts) {
        material::MaterialAppearance& appearance =
            appearances[static_cast<std::size_t>(part.material)];
        appearance.colour = part.albedo;
        appearance.emission = part.emission;
    }
    scene::Scene scene = scene_of(roofed);
    std::array<LinearPicture, 2> halves;
    double cpu_s = 0;
    for (int seed = 0; seed < 2; ++seed) {
        scene.quality.seed = seed;
        shade::View view = shade::make_view(scene, blocks);
        view.materials = std::make_shared<material::MaterialTable>(appearances);
        TracedPicture traced = trace_picture(view, blocks, c.threads);
        halves[static_cast<std::size_t>(seed)] = std::move(traced.picture);
        cpu_s += traced.cost.cpu_s;
    }
    LinearPicture ours = halves[0];
    for (std::size_t i = 0; i < ours.rgb.size(); ++i)
        ours.rgb[i] = (ours.rgb[i] + halves[1].rgb[i]) / 2;
    const LinearPicture theirs = reference(c, *world, scene, roofed, readings);
    const double mean = mean_of(theirs);
    readings.add("our picture, CPU", "s", cpu_s);
    readings.add("RMSE to Mitsuba / mean", "%", 100 * rms_difference(ours, theirs) / mean,
                 at_most(3));
    readings.add("of that our noise", "%",
                 100 * noise_of(halves[0], halves[1]) / std::numbers::sqrt2 / mean);
    readings.add("mean / Mitsuba's", "x", mean_of(ours) / mean);
}

Entry entry(const char* name, bool roofed, const char* work) {
    Entry out;
    out.name = name;
    out.measures =
        "path tracing beside Mitsuba 3: the difference of the pictures in linear light, share of "
        "their mean";
    out.work = work;
    out.floor = "Mitsuba 3 on the faces of the same voxels, path, 8192 samples";
    out.exact = out.only_by_name = true;
    out.missing = missing;
    out.prepare = [roofed](const Context& c) -> Body {
        return [roofed, &c](Readings& readings) { measure(c, roofed, readings); };
    };
    return out;
}

const Registration kRegistered([] {
    return std::vector{entry("light/cornell", true,
                             "a closed room of 32 x 32 x 32 voxels: red, green and white walls, "
                             "two blocks, a lamp in the ceiling; 32x32, 16384 samples, 64 bounces"),
                       entry("light/cornell/sun", false,
                             "the same room without its ceiling, under a sun of four times the "
                             "true radius and an even blue sky")};
});

}  // namespace
}  // namespace terravox::bench::light_cornell_entry
