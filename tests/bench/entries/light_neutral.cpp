#include "tests/bench/entries/light_neutral.hpp"

#include <cstdio>
#include <numbers>

#include "raytracer/shade/view_maker.hpp"
#include "raytracer/walk/traced_ray.hpp"

namespace terravox::bench {
namespace {

constexpr std::size_t kBoxMemory_bytes = std::size_t{1} << 30;

}  // namespace

NeutralLight::NeutralLight(const Context& c)
    : scene(c), world(scene, c.threads), blocks(world, kBoxMemory_bytes) {
    const voxel::BoxRange range = voxel::boxes_over(world.info().bounds, 0);
    for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx)
        for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz)
            (void)blocks.get({0, bx, 0, bz});
}

scene::Scene NeutralLight::scene_of(const NeutralView& view, int samples) {
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
    scene.quality.samples = samples;
    scene.quality.bounces = kBounces;
    scene.quality.clamp = 0;
    scene.quality.coarse_step = 1;
    scene.quality.textures = false;
    return scene;
}

TracedPicture NeutralLight::trace(const scene::Scene& picture, int threads) {
    shade::View view = shade::make_view(picture, blocks);
    view.materials = grey_materials(kGrey);
    return trace_picture(view, blocks, threads);
}

std::string rays_of(const std::string& name, const render::RenderCounts& counts) {
    const auto primary =
        static_cast<double>(counts.trace.rays[static_cast<std::size_t>(walk::RayKind::kPrimary)]);
    std::string out = "Rays a sample, " + name + ":";
    for (std::size_t kind = 0; kind < walk::kRayKinds; ++kind) {
        const double rays = static_cast<double>(counts.trace.rays[kind]) / primary;
        std::array<char, 48> text{};
        if (rays > 0)
            std::snprintf(text.data(), text.size(), " %s %.2f,",
                          walk::name_of(static_cast<walk::RayKind>(kind)), rays);
        out += text.data();
    }
    out.back() = '.';
    return out;
}

}  // namespace terravox::bench
