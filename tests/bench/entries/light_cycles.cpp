#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "raytracer/shade/view_maker.hpp"
#include "raytracer/walk/traced_ray.hpp"
#include "tests/bench/entries/embree_mesh.hpp"
#include "tests/bench/entries/light_picture.hpp"

namespace terravox::bench::light_cycles_entry {
namespace {

constexpr int kBounces = 3;
constexpr int kSamples = 64;
constexpr float kGrey = 0.8f;
constexpr std::array<double, 3> kSky = {0.5, 0.7, 1};
// A sun lamp's strength is the irradiance of what faces it; a white surface sends 1 / pi of that.
constexpr double kSunIrradiance = 3;
constexpr double kSunRadius_deg = 0.2666;
constexpr std::array kSeeds = {1, 2};
constexpr double kMaxMeanDifference = 0.03;  // above it the two did not render the same
constexpr std::size_t kBoxMemory_bytes = std::size_t{1} << 30;

std::string missing(const Context& c) {
    if (const std::string scene = NeutralScene::missing(c); !scene.empty())
        return scene;
    return c.children.run({"blender", "--version"}, c.scratch / "blender.txt").exit_code == 0
               ? ""
               : "Blender is not installed (Debian package blender)";
}

scene::Scene scene_of(const NeutralView& view) {
    scene::Scene scene;
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.camera.position = {view.position.x, view.position.y, view.position.z};
    scene.camera.target = {view.target.x, view.target.y, view.target.z};
    scene.camera.fov_deg = view.fov_deg;
    set_sun(scene, neutral_sun());
    constexpr double kWhite = kSunIrradiance / std::numbers::pi;
    scene.sun.light = {kWhite, kWhite, kWhite};
    scene.sky.model = core::SkyModel::kUniform;
    scene.sky.colour = kSky;
    scene.output.size_px = {NeutralScene::kWidthPx, NeutralScene::kHeightPx};
    scene.quality.integrator = core::Integrator::kPath;
    scene.quality.samples = kSamples;
    scene.quality.bounces = kBounces;
    scene.quality.clamp = 0;
    scene.quality.coarse_step = 1;
    scene.quality.textures = false;
    return scene;
}

/// The same voxels for both.
struct Bodies {
    Bodies(const Context& c)
        : scene(c),
          world(scene, c.threads),
          blocks(world, kBoxMemory_bytes),
          mesh(c.scratch / "light-mesh.f32") {
        const voxel::BoxRange range = voxel::boxes_over(world.info().bounds, 0);
        for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx)
            for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz)
                (void)blocks.get({0, bx, 0, bz});
        std::ofstream file(mesh, std::ios::binary);
        for (const QuadMesh& slab : mesh_slabs(scene, c.threads))
            file.write(reinterpret_cast<const char*>(slab.corners.data()),
                       static_cast<std::streamsize>(slab.corners.size() * sizeof(float)));
        if (!file.flush())
            throw util::Error("write the mesh " + mesh.string());
    }
    NeutralScene scene;
    NeutralWorld world;
    blocks::BlockManager blocks;
    std::filesystem::path mesh;
};

/// Both seeds of a view, by one renderer.
struct Rendered {
    std::array<LinearPicture, 2> pictures;
    Cost cost;  ///< of one picture: the cheaper of the two, each for itself
    render::RenderCounts counts;
    [[nodiscard]] double noise() const { return noise_of(pictures[0], pictures[1]); }
    [[nodiscard]] double mean() const noexcept {
        return (mean_of(pictures[0]) + mean_of(pictures[1])) / 2;
    }
    void took(const Cost& one, bool first) noexcept {
        cost =
            first ? one : Cost{std::min(cost.wall_s, one.wall_s), std::min(cost.cpu_s, one.cpu_s)};
    }
};

Rendered ours(Bodies& bodies, const NeutralView& view, int threads) {
    Rendered out;
    for (std::size_t i = 0; i < kSeeds.size(); ++i) {
        scene::Scene scene = scene_of(view);
        scene.quality.seed = kSeeds[i];
        shade::View with = shade::make_view(scene, bodies.blocks);
        with.materials = grey_materials(kGrey);
        TracedPicture traced = trace_picture(with, bodies.blocks, threads);
        out.pictures[i] = std::move(traced.picture);
        out.counts = traced.counts;
        out.took(traced.cost, i == 0);
    }
    return out;
}

nlohmann::json vector_of(core::Vec3 v) {
    return {v.x, v.y, v.z};
}

/// All views by the peer. @return its figures, which cycles_render.py describes
nlohmann::json run_cycles(const Context& c, const Bodies& bodies) {
    nlohmann::json job = {
        {"mesh", bodies.mesh.string()}, {"albedo", kGrey}, {"sky", kSky}, {"bounces", kBounces}};
    job["samples"] = kSamples;
    job["threads"] = c.threads;
    job["seeds"] = kSeeds;
    job["sun"] = {{"to", vector_of(neutral_sun())},
                  {"irradiance", kSunIrradiance},
                  {"radius_rad", kSunRadius_deg * std::numbers::pi / 180}};
    job["size_px"] = {NeutralScene::kWidthPx, NeutralScene::kHeightPx};
    for (const NeutralView& view : neutral_views())
        job["views"].push_back({{"name", view.name},
                                {"position", vector_of(view.position)},
                                {"target", vector_of(view.target)},
                                {"fov_deg", view.fov_deg}});
    const auto figures = c.scratch / "cycles-figures.json";
    const auto file = c.scratch / "cycles-job.json";
    job["pictures"] = c.scratch.string();
    job["figures"] = figures.string();
    util::write_file_atomically(file, job.dump());
    return figures_of(c,
                      {"blender", "-b", "--python-exit-code", "1", "-P",
                       light_script("cycles_render.py"), "--", file.string()},
                      figures);
}

Rendered theirs(const Context& c, const nlohmann::json& figures, const std::string& view) {
    Rendered out;
    for (std::size_t i = 0; i < kSeeds.size(); ++i) {
        const std::string seed = std::to_string(kSeeds[i]);
        const auto& took = figures.at("views").at(view).at(seed);
        out.pictures[i] = read_picture(c.scratch / (view + "-" + seed + ".f32"),
                                       NeutralScene::kWidthPx, NeutralScene::kHeightPx);
        out.took({took.at("wall_s"), took.at("cpu_s")}, i == 0);
    }
    return out;
}

/// How many rays of each kind a sample took.
std::string rays_of(const std::string& name, const Rendered& our) {
    std::string out = "Rays a sample, " + name + ":";
    for (std::size_t kind = 0; kind < walk::kRayKinds; ++kind) {
        const double rays = static_cast<double>(our.counts.trace.rays[kind]) /
                            (double{kSamples} * NeutralScene::kWidthPx * NeutralScene::kHeightPx);
        std::array<char, 48> text{};
        if (rays > 0)
            std::snprintf(text.data(), text.size(), " %s %.2f,",
                          walk::name_of(static_cast<walk::RayKind>(kind)), rays);
        out += text.data();
    }
    out.back() = '.';
    return out;
}

void add_view(const std::string& name, const Rendered& our, const Rendered& their,
              Readings& readings) {
    const double mean_ratio = our.mean() / their.mean();
    if (!(std::abs(mean_ratio - 1) < kMaxMeanDifference))
        throw util::Error("compare with Cycles: " + name + ": means of " +
                          std::to_string(our.mean()) + " and " + std::to_string(their.mean()));
    const double our_variance = our.noise() * our.noise();
    const double their_variance = their.noise() * their.noise();
    readings.add(name + ": CPU time", "s", our.cost.cpu_s);
    readings.add(name + ": CPU time, Cycles", "s", their.cost.cpu_s);
    readings.add(name + ": rays", "Mray/s of CPU",
                 static_cast<double>(our.counts.trace.all_rays()) / our.cost.cpu_s / 1e6);
    readings.add(name + ": noise / mean", "%", 100 * our.noise() / our.mean());
    readings.add(name + ": noise / mean, Cycles", "%", 100 * their.noise() / their.mean());
    readings.add(name + ": mean / Cycles' mean", "x", mean_ratio);
    readings.add(name + ": time at equal samples / Cycles", "x", our.cost.cpu_s / their.cost.cpu_s);
    readings.add(name + ": time to the same noise / Cycles", "x",
                 our.cost.cpu_s * our_variance / (their.cost.cpu_s * their_variance), at_most(0.2));
}

Entry entry() {
    Entry out;
    out.name = "light/cycles";
    out.measures =
        "path tracing beside Blender's Cycles: processor time, noise, time to the same noise; the "
        "means must agree";
    out.work =
        "the voxels of trace/neutral, all matt grey 0.8, sun and even sky, 3 bounces, 64 samples, "
        "1280x720, three cameras, two seeds";
    out.floor =
        "Cycles on the visible faces of the same voxels, its scene in memory, N threads as ours";
    out.only_by_name = true;
    out.missing = missing;
    out.prepare = [](const Context& c) -> Body {
        const auto bodies = std::make_shared<Bodies>(c);
        return [bodies, &c](Readings& readings) {
            const nlohmann::json figures = run_cycles(c, *bodies);
            for (const NeutralView& view : neutral_views()) {
                const Rendered our = ours(*bodies, view, c.threads);
                add_view(view.name, our, theirs(c, figures, view.name), readings);
                readings.note(rays_of(view.name, our));
            }
            const int build_s = static_cast<int>(std::lround(figures.at("build_s").get<double>()));
            readings.note("Cycles of Blender " + figures.at("blender").get<std::string>() +
                          "; its first, tiny picture with the building of its BVH: " +
                          std::to_string(build_s) + " s.");
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::light_cycles_entry
