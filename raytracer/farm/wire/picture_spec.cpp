#include "raytracer/farm/wire/picture_spec.hpp"

#include <xxhash.h>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/toml_file.hpp"
#include "raytracer/analyse/evaluators/analysis.hpp"
#include "raytracer/analyse/solar/place_and_clock.hpp"
#include "raytracer/core/material/appearance.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "raytracer/core/sky/sun.hpp"

namespace terravox::farm {
namespace {

/// The scene with everything resolved that depends on tables of this machine: time zones, map
/// projections, named views. No path is left.
scene::Scene decided(const scene::Scene& scene, const voxel::WorldInfo& world) {
    scene::Scene out = scene::what_shows(scene);
    const scene::Scene plain;
    out.world = plain.world;
    out.camera.look.clear();
    out.quality.materials.clear();
    const auto in_voxels = [&](std::optional<std::array<double, 3>>& point) {
        if (!point)
            return;
        const core::Vec3 v = scene::to_voxels(*point, scene.camera.space, world);
        point = {v.x, v.y, v.z};
    };
    in_voxels(out.camera.position);
    in_voxels(out.camera.target);
    out.camera.space = core::CoordinateSpace::kVoxel;
    const auto precision = scene.analysis.kind == core::AnalysisKind::kNone
                               ? geo::SunPrecision::kPicture
                               : geo::SunPrecision::kAnalysis;
    const auto place = solar::find_place(scene, world.centre);
    const geo::SunPosition sun = sky::compute_sun(scene.sun, place ? &*place : nullptr, precision);
    out.sun.altitude_deg = sun.altitude_deg;
    out.sun.azimuth_deg = sun.azimuth_deg;
    out.sun.zone.clear();
    if (place && scene.analysis.kind != core::AnalysisKind::kNone && !scene.sun.zone.empty())
        out.analysis.clock = solar::Clock(scene, *place).text();
    return out;
}

}  // namespace

PictureSpec pack(const scene::Scene& scene, const voxel::WorldInfo& world) {
    const std::filesystem::path file = material::find_materials(scene.quality.materials);
    return {scene::to_toml(decided(scene, world)),
            util::read_text(file, util::kMaxToml_bytes, "read the materials " + file.string()),
            pack_world(world)};
}

std::string pack_world(const voxel::WorldInfo& world) {
    voxel::WorldInfo out = world;
    out.crs_wkt.clear();
    return voxel::world_to_json(out);
}

voxel::WorldInfo unpack_world(const std::string& text) {
    voxel::WorldInfo world = voxel::world_from_json(text, "the coordinator");
    world.crs_wkt.clear();
    return world;
}

scene::Scene unpack_scene(const std::string& text) {
    scene::Scene scene;
    scene::parse_scene(text, "of the coordinator", scene);
    const scene::Scene plain;
    if (!(scene.world == plain.world) || !(scene.processing == plain.processing) ||
        !scene.camera.look.empty() || !scene.sun.zone.empty() || !scene.quality.materials.empty())
        throw util::UsageError(
            "read the scene of the coordinator: it names files or limits of this machine; allowed: "
            "what shows in the picture");
    return scene;
}

shade::View unpack(const PictureSpec& spec, const voxel::WorldInfo& world) {
    return shade::make_view(
        unpack_scene(spec.scene), world,
        std::make_shared<material::MaterialTable>(
            material::parse_materials(spec.materials, "of the coordinator").appearances),
        analyse::measure);
}

std::string state_hash(const std::string& content) {
    XXH128_canonical_t name;
    XXH128_canonicalFromHash(&name, XXH3_128bits(content.data(), content.size()));
    return {reinterpret_cast<const char*>(name.digest), sizeof name.digest};
}

}  // namespace terravox::farm
