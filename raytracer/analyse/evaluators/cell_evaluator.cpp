#include "raytracer/analyse/evaluators/cell_evaluator.hpp"

#include <cmath>

#include "common/util/det_math.hpp"

namespace terravox::analyse {

double on_grid(double at) noexcept {
    constexpr double kSteps = 1024;
    return std::floor(at * kSteps + 0.5) / kSteps;
}

walk::TracedRay cell_ray(const core::Ray& ray, std::uint32_t sample) noexcept {
    walk::TracedRay out;
    out.ray = {{on_grid(ray.origin.x), ray.origin.y, on_grid(ray.origin.z)}, {0, -1, 0}};
    out.sample = sample;
    return out;
}

double cell_spacing(const shade::View& view) noexcept {
    const auto& scene = view.scene;
    return scene.camera.height_m.value_or(0) / scene.output.size_px[1] / view.voxel_m;
}

walk::TracedRay ray_beside(const shade::View& view, const walk::TracedRay& ray, double east,
                           double south) noexcept {
    core::Ray down = ray.ray;
    down.origin = {down.origin.x + east, view.camera.position().y, down.origin.z + south};
    walk::TracedRay out = cell_ray(down, ray.sample);
    out.state = core::RayState(out.ray);
    if (!out.state.enter(view.cut.entry_bounds()))
        out.end = walk::WalkEnd::kMiss;
    return out;
}

core::VoxelCoord voxel_at(core::Vec3 at, int level) noexcept {
    const double scale = det::exp2_int(-level);
    return {core::RayState::floor_to_int(at.x * scale), core::RayState::floor_to_int(at.y * scale),
            core::RayState::floor_to_int(at.z * scale)};
}

double find_top(const walk::Hit& hit) noexcept {
    return static_cast<double>(hit.voxel.y + 1) * det::exp2_int(hit.level);
}

bool is_ground(voxel::Material material) noexcept {
    const voxel::Grain grain = voxel::find_traits(material).grain;
    return grain == voxel::Grain::kTerrain || grain == voxel::Grain::kWater;
}

Descent descent_at(const walk::TracedRay& ray) noexcept {
    // A ray of below() starts at the bottom of the voxel that it went through: at 0 there is no air
    // between that voxel and this one.
    if (ray.hit.t == 0 && !voxel::see_through(ray.medium))
        return Descent::kCovered;
    return is_ground(ray.hit.attr.material) ? Descent::kGround : Descent::kContinues;
}

CellStep cell_step_at(const walk::TracedRay& ray, core::AnalysisSurface surface) noexcept {
    if (ray.end != walk::WalkEnd::kHit || ray.hit.hole)
        return CellStep::kNothing;
    if (surface == core::AnalysisSurface::kTop)
        return CellStep::kMeasure;
    // Grass and crops as high as a voxel or two are what people stand in, not what shades them.
    if (ray.hit.attr.material == voxel::Material::kLowVegetation)
        return CellStep::kMeasure;
    switch (descent_at(ray)) {
        case Descent::kGround: return CellStep::kMeasure;
        case Descent::kCovered: break;
        case Descent::kContinues: return CellStep::kDescend;
    }
    return CellStep::kNothing;
}

walk::TracedRay below(const walk::TracedRay& ray) noexcept {
    const walk::Hit& hit = ray.hit;
    walk::TracedRay out;
    out.ray = ray.ray;
    out.ray.origin.y = static_cast<double>(hit.voxel.y) * det::exp2_int(hit.level);
    out.state = core::RayState(out.ray);
    out.state.start_in({hit.voxel.x, hit.voxel.y - 1, hit.voxel.z}, hit.level);
    out.sample = ray.sample;
    out.stream = ray.stream;
    out.depth = 1;
    out.medium = hit.attr.material;
    return out;
}

FanStart start_at(core::Vec3 at, int level, std::uint32_t sample) noexcept {
    return {at, voxel_at(at, level), level, sample};
}

FanStart start_above(const walk::TracedRay& ray) noexcept {
    const walk::Hit& hit = ray.hit;
    return {{ray.ray.origin.x, find_top(hit), ray.ray.origin.z},
            {hit.voxel.x, hit.voxel.y + 1, hit.voxel.z},
            hit.level,
            ray.sample};
}

FanStart find_start(const walk::TracedRay& fan) noexcept {
    const auto& voxel = fan.state.voxel;
    return {fan.ray.origin, {voxel[0], voxel[1], voxel[2]}, fan.state.level, fan.sample};
}

walk::TracedRay through(const walk::TracedRay& ray) noexcept {
    walk::TracedRay out = ray;
    out.state = core::RayState(out.ray);
    out.state.start_in(ray.hit.voxel, ray.hit.level);
    out.state.t = ray.hit.t;
    out.state.face = ray.hit.face;
    out.stop = {ray.hit.attr.material, false};
    out.end = walk::WalkEnd::kWaits;
    return out;
}

walk::TracedRay& add_fan(const FanStart& start, walk::RayKind kind, walk::FanMask mask,
                         std::uint32_t stream, std::vector<walk::TracedRay>& next) {
    walk::TracedRay& out = next.emplace_back();
    out.ray.origin = start.at;
    out.state.start_in(start.voxel, start.level);
    out.sample = start.sample;
    out.kind = kind;
    out.fan_mask = mask;
    out.stream = stream;
    return out;
}

walk::FanMask free_rays(const walk::TracedRay& fan, walk::FanEnds ends,
                        const shade::RayEvaluator& evaluator, const Sunlight& sunlight) {
    auto free = static_cast<walk::FanMask>(fan.fan_mask & ~ends.blocked);
    if (sunlight.horizon.empty())
        return free;
    const walk::FanDirections directions = evaluator.directions(fan.stream);
    for (std::size_t i = 0; i < directions.count; ++i)
        if (walk::has(free, i) && sunlight.horizon.hides(fan.ray.origin, directions.to[i]))
            free = static_cast<walk::FanMask>(free & ~(1U << i));
    return free;
}

}  // namespace terravox::analyse
