#include "raytracer/analyse/evaluators/sun_view_evaluator.hpp"

#include <algorithm>

#include "raytracer/analyse/evaluators/cell_fan.hpp"
#include "raytracer/analyse/evaluators/column_descent.hpp"

namespace terravox::analyse {

walk::TracedRay SunViewEvaluator::primary(const core::Ray& ray,
                                          std::uint32_t sample) const noexcept {
    walk::TracedRay out;
    out.ray = ray;
    out.sample = sample;
    return out;
}

void SunViewEvaluator::shade(const walk::TracedRay& ray, shade::SampleSum& sum,
                             std::vector<walk::TracedRay>& next) const {
    if (is_hole(ray))
        sum.direct.g = 1;
    else if (ray.end == walk::WalkEnd::kHit)
        shade_face(ray, sum, next);
}

// Each pixel has moments of its own: its fans have one ray.
walk::FanDirections SunViewEvaluator::directions(std::uint32_t stream) const {
    walk::FanDirections out;
    out.add(m_view.sun_way.directions[stream].to);
    return out;
}

void SunViewEvaluator::shade_fan(const walk::TracedRay& fan, walk::FanEnds ends,
                                 shade::SampleSum& sum,
                                 std::vector<walk::TracedRay>& /*next*/) const {
    if (ends.holes != 0)
        sum.direct.g = 1;
    else if (free_rays(fan, ends, *this, m_view) != 0)
        sum.direct.r += fan.weight.r;
}

void SunViewEvaluator::shade_face(const walk::TracedRay& ray, shade::SampleSum& sum,
                                  std::vector<walk::TracedRay>& next) const {
    sum.t = ray.hit.t;
    const auto& directions = m_view.sun_way.directions;
    if (ray.hit.face == core::Face::kNone || directions.empty())
        return;
    const core::Vec3 normal = core::normal_of(ray.hit.face);
    const core::Vec3 from = ray.ray.origin + ray.ray.direction * ray.hit.t;
    const FanStart start{from, walk::neighbour(ray.hit.voxel, ray.hit.face), ray.hit.level,
                         ray.sample};
    const auto count = static_cast<double>(directions.size());
    const std::size_t rays = std::min(kRays, directions.size());
    const double first = sum.numbers.number(0);
    for (std::size_t i = 0; i < rays; ++i) {
        const double share = (static_cast<double>(i) + first) / static_cast<double>(rays);
        const auto index = std::min(static_cast<std::size_t>(share * count), directions.size() - 1);
        const solar::SunDirection& sun = directions[index];
        if (core::dot(normal, sun.to) <= 0)
            continue;
        walk::TracedRay& out = add_fan(start, walk::RayKind::kShadow, walk::mask_of_first(1),
                                       static_cast<std::uint32_t>(index), next);
        out.weight.r = static_cast<float>(sun.hours / m_view.sun_way.hours * count /
                                          static_cast<double>(rays));
    }
}

}  // namespace terravox::analyse
