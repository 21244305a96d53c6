#include "raytracer/core/shade/view.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/det_math.hpp"
#include "common/util/error.hpp"
#include "raytracer/core/material/appearance.hpp"
#include "raytracer/core/sky/sun.hpp"
#include "raytracer/core/walk/surroundings.hpp"

namespace terravox::shade {
namespace {

/// Whether a voxel of a level is solid; blocks until its box is loaded.
bool solid_at(blocks::BlockManager& blocks, const walk::LevelCut& cut, core::VoxelCoord at,
              int level) {
    walk::BlockReader reader(blocks);
    walk::Surroundings surroundings(reader, cut);
    bool solid = false;
    while (!surroundings.look(at, level, solid))
        (void)blocks.get(surroundings.missing());
    blocks.check_world();  // a hole counts as solid
    return solid;
}

/// Stops that compensate for a dim sun and sky, computed from the light they send to level ground.
double adaptation_ev(const sky::Sky& sky, double share) noexcept {
    constexpr double kFullDay = 1;
    constexpr double kDarkest = 1e-6;
    constexpr double kMax_ev = 9;
    constexpr double kLn2 = 0.693147180559945309417;
    const double level = static_cast<double>(
        voxel::luminance(sky.ambient(core::Face::kTop) +
                         sky.sun_light() * static_cast<float>(std::max(0.0, sky.to_sun().y))));
    return std::clamp(-share * det::log(std::max(level, kDarkest) / kFullDay) / kLn2, 0.0, kMax_ev);
}

void check_camera(const View& view, blocks::BlockManager& blocks) {
    if (view.scene.camera.inside_rock)
        return;
    const int level = view.scene.quality.level;
    const core::Vec3 p = view.camera.position() * (1.0 / (1 << level));
    for (const double c : {p.x, p.y, p.z})
        if (!(std::abs(c) < 1.0e9))
            throw util::UsageError("place the camera: its position lies beyond 10^9 voxels");
    core::VoxelCoord at{static_cast<std::int32_t>(std::floor(p.x)),
                        static_cast<std::int32_t>(std::floor(p.y)),
                        static_cast<std::int32_t>(std::floor(p.z))};
    const voxel::VoxelBounds& bounds = view.cut.bounds(level);
    for (int a = 0; a < 3; ++a)
        if (at[a] < bounds.min[static_cast<std::size_t>(a)] ||
            at[a] >= bounds.max[static_cast<std::size_t>(a)])
            return;
    if (!solid_at(blocks, view.cut, at, level))
        return;
    const core::VoxelCoord found = at;
    while (at.y < bounds.max[1] && solid_at(blocks, view.cut, at, level))
        ++at.y;
    throw util::UsageError("place the camera: voxel (" + std::to_string(found.x) + ", " +
                           std::to_string(found.y) + ", " + std::to_string(found.z) +
                           ") is solid; allowed: " +
                           std::to_string(static_cast<int>(
                               std::ceil((at.y - found.y) * view.voxel_m * (1 << level)))) +
                           " m higher, or --camera-inside-rock yes");
}

/// @param find_sky makes the sky
template <class FindSky>
View assemble(const scene::Scene& scene, const voxel::WorldInfo& world,
              std::shared_ptr<const material::MaterialTable> materials, MakeMeasuring measure,
              const FindSky& find_sky) {
    const int level = scene.quality.level;
    if (level >= world.levels)
        throw util::UsageError("choose the level: quality.level = " + std::to_string(level) +
                               "; this world has 0 to " + std::to_string(world.levels - 1));
    if (world.bounds.empty())
        throw util::Error("render the world '" + world.title + "': it is empty");
    const scene::Camera camera = scene::make_camera(scene, world, world.camera_bounds());
    const bool has_end = world.framed.empty();
    const walk::LevelCut cut(has_end ? world.bounds : walk::within_horizon(world.bounds, camera),
                             camera, scene.quality.detail, level, world.levels - 1);
    const geo::SunPosition sun =
        sky::compute_sun(scene.sun, world.centre ? &*world.centre : nullptr);
    constexpr double kLampsOn_deg = -2;
    // Lamps that emit nothing need not be looked for.
    const auto shine = [](const material::MaterialAppearance& lamp) {
        return lamp.kind == material::Kind::kSolid && voxel::luminance(lamp.emission) > 0;
    };
    const auto origin = camera.picture_origin();
    View view{scene,
              camera,
              find_sky(ViewMaker::SkyParameters{sun, scene.sun, scene.sky,
                                                world.bounds.min[1] * world.voxel_m,
                                                camera.position() * world.voxel_m}),
              std::move(materials),
              cut,
              world.voxel_m,
              tiles::SquareGrid(world),
              {static_cast<double>(origin[0]), static_cast<double>(origin[1]),
               static_cast<double>(origin[2])},
              sun.altitude_deg < kLampsOn_deg};
    view.lamps = view.night && shine(view.materials->appearance(voxel::Material::kLamp));
    view.exposure_ev = scene.output.exposure_ev + adaptation_ev(view.sky, scene.output.adaptation);
    if (measure == nullptr)
        scene::check_is_picture(scene);
    else
        view.measuring = measure(scene, world);
    if (scene.quality.integrator == core::Integrator::kPath)
        view.max_indirect =
            static_cast<float>(scene.quality.clamp * det::pow(2, -view.exposure_ev));
    return view;
}

sky::Sky make_sky(const ViewMaker::SkyParameters& asked) {
    return {asked.sun, asked.sun_settings, asked.sky_settings, asked.place_height_m, asked.eye_m};
}

}  // namespace

View make_view(const scene::Scene& scene, const voxel::WorldInfo& world,
               std::shared_ptr<const material::MaterialTable> materials, MakeMeasuring measure) {
    return assemble(scene, world, std::move(materials), measure, make_sky);
}

View make_view(const scene::Scene& scene, blocks::BlockManager& blocks, MakeMeasuring measure) {
    return ViewMaker(measure).make(scene, blocks);
}

View ViewMaker::make(const scene::Scene& scene, blocks::BlockManager& blocks) {
    if (!m_materials || m_named != scene.quality.materials) {
        m_materials = std::make_shared<material::MaterialTable>(
            material::find_materials(scene.quality.materials));
        m_named = scene.quality.materials;
    }
    const auto find_sky = [this](SkyParameters asked) {
        if (asked.sky_settings.clouds == 0)
            asked.eye_m = {};
        if (!m_sky || m_sky->first != asked)
            m_sky.emplace(asked, make_sky(asked));
        return m_sky->second;
    };
    View view = assemble(scene, blocks.world_info(), m_materials, m_measure, find_sky);
    check_camera(view, blocks);
    return view;
}

}  // namespace terravox::shade
