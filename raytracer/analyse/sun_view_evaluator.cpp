#include "raytracer/analyse/sun_view_evaluator.hpp"

#include <algorithm>

#include "raytracer/analyse/column_descent.hpp"

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
    if (is_hole(ray)) {
        sum.direct.g = 1;
        return;
    }
    if (ray.kind == walk::RayKind::kPrimary) {
        if (ray.end == walk::WalkEnd::kHit)
            shade_face(ray, sum, next);
    } else if (is_free(ray, m_view)) {
        sum.direct.r += ray.weight.r;
    }
}

void SunViewEvaluator::shade_face(const walk::TracedRay& ray, shade::SampleSum& sum,
                                  std::vector<walk::TracedRay>& next) const {
    sum.t = ray.hit.t;
    const auto& directions = m_view.sun_way.directions;
    if (ray.hit.face == core::Face::kNone || directions.empty())
        return;
    const core::Vec3 normal = core::normal_of(ray.hit.face);
    const core::Vec3 from = ray.ray.origin + ray.ray.direction * ray.hit.t;
    const auto count = static_cast<double>(directions.size());
    const std::size_t rays = std::min(kRays, directions.size());
    const double first = sum.numbers.number(0);
    for (std::size_t i = 0; i < rays; ++i) {
        const double share = (static_cast<double>(i) + first) / static_cast<double>(rays);
        const auto index = std::min(static_cast<std::size_t>(share * count), directions.size() - 1);
        const solar::SunDirection& sun = directions[index];
        if (core::dot(normal, sun.to) <= 0)
            continue;
        walk::TracedRay& out = next.emplace_back();
        out.ray = {from, sun.to};
        out.state = core::RayState(out.ray);
        out.state.start_in(walk::neighbour(ray.hit.voxel, ray.hit.face), ray.hit.level);
        out.weight.r = static_cast<float>(sun.hours / m_view.sun_way.hours * count /
                                          static_cast<double>(rays));
        out.sample = ray.sample;
        out.stream = static_cast<std::uint32_t>(index);
        out.kind = walk::RayKind::kShadow;
    }
}

}  // namespace terravox::analyse
