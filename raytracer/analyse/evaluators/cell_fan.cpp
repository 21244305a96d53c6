#include "raytracer/analyse/evaluators/cell_fan.hpp"

#include "raytracer/analyse/evaluators/column_descent.hpp"

namespace terravox::analyse {

FanStart start_at(core::Vec3 at, int level, std::uint32_t sample) noexcept {
    return {at, voxel_at(at, level), level, sample};
}

FanStart start_above(const walk::TracedRay& ray) noexcept {
    const walk::Hit& hit = ray.hit;
    return {{ray.ray.origin.x, top_of(hit), ray.ray.origin.z},
            {hit.voxel.x, hit.voxel.y + 1, hit.voxel.z},
            hit.level,
            ray.sample};
}

FanStart start_of(const walk::TracedRay& fan) noexcept {
    const auto& voxel = fan.state.voxel;
    return {fan.ray.origin, {voxel[0], voxel[1], voxel[2]}, fan.state.level, fan.sample};
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
                        const shade::RayEvaluator& evaluator, const shade::View& view) {
    auto free = static_cast<walk::FanMask>(fan.fan_mask & ~ends.blocked);
    if (view.horizon.empty())
        return free;
    const walk::FanDirections directions = evaluator.directions(fan.stream);
    for (std::size_t i = 0; i < directions.count; ++i)
        if (walk::has(free, i) && view.horizon.hides(fan.ray.origin, directions.to[i]))
            free = static_cast<walk::FanMask>(free & ~(1U << i));
    return free;
}

}  // namespace terravox::analyse
