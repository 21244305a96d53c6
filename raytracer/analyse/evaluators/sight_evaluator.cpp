#include "raytracer/analyse/evaluators/sight_evaluator.hpp"

#include <algorithm>

#include "raytracer/analyse/evaluators/bands.hpp"
#include "raytracer/analyse/evaluators/column_descent.hpp"

namespace terravox::analyse {
namespace {

using core::SightBand;

// A point on the surface lies a little above it, in the air: a line of sight must not end in the
// face that it looks for.
constexpr double kMinTarget_voxels = 1.0 / 1024;

double range2_of(const shade::View& view) noexcept {
    const double range_m = view.scene.analysis.range_m;
    const double range = range_m > 0 ? range_m / view.voxel_m : core::kFar;
    return range * range;
}

double sag_of(const shade::View& view) noexcept {
    const auto& analysis = view.scene.analysis;
    return analysis.curvature ? sag_of_sight(view.voxel_m, analysis.refraction) : 0;
}

}  // namespace

SightEvaluator::SightEvaluator(const shade::View& view)
    : m_view(view),
      m_sag(sag_of(view)),
      m_range2(range2_of(view)),
      m_target_voxels(std::max(view.scene.analysis.target_m / view.voxel_m, kMinTarget_voxels)) {
    for (const std::array<double, 3>& at : view.scene.analysis.observers.points)
        m_observers.push_back(on_sight_grid({at[0], at[1], at[2]}));
}

void SightEvaluator::shade(const walk::TracedRay& ray, shade::SampleSum& sum,
                           std::vector<walk::TracedRay>& next) const {
    if (ray.kind == walk::RayKind::kPrimary) {
        shade_cell(ray, sum, next);
        return;
    }
    if (at(sum.bands, SightBand::kHole) > 0)
        return;
    if (ray.end != walk::WalkEnd::kHit)
        arrive(ray, sum, next);
    else if (ray.hit.hole)
        sum.bands = no_values(SightBand::kHole, true);
}

void SightEvaluator::shade_cell(const walk::TracedRay& ray, shade::SampleSum& sum,
                                std::vector<walk::TracedRay>& next) const {
    sum.bands = no_values(SightBand::kHole, is_hole(ray));
    switch (cell_step_at(ray, m_view.scene.analysis.surface)) {
        case CellStep::kMeasure: send_to_observers(ray, sum, next); break;
        case CellStep::kDescend: next.push_back(below(ray)); break;
        case CellStep::kNothing: break;
    }
}

void SightEvaluator::send_to_observers(const walk::TracedRay& ray, shade::SampleSum& sum,
                                       std::vector<walk::TracedRay>& next) const {
    at(sum.bands, SightBand::kSeen) = 0;
    at(sum.bands, SightBand::kClass) = ray.hit.attr.source_class;
    at(sum.bands, SightBand::kMaterial) = static_cast<float>(ray.hit.attr.material);
    sum.point =
        on_sight_grid({ray.ray.origin.x, top_of(ray.hit) + m_target_voxels, ray.ray.origin.z});
    for (std::size_t observer = 0; observer < m_observers.size(); ++observer)
        if (horizontal_distance2(m_observers[observer], sum.point) <= m_range2)
            next.push_back(along(line_to(observer, sum.point), observer, 0, ray.sample));
}

// At the end of a free chord: on along the line, or at its end the cell is seen.
void SightEvaluator::arrive(const walk::TracedRay& ray, shade::SampleSum& sum,
                            std::vector<walk::TracedRay>& next) const {
    const std::size_t observer = ray.stream % m_observers.size();
    const auto chord = static_cast<std::uint32_t>(ray.stream / m_observers.size()) + 1;
    const SightLine line = line_to(observer, sum.point);
    if (chord < line.chords()) {
        next.push_back(along(line, observer, chord, ray.sample));
        return;
    }
    const auto distance_m =
        static_cast<float>(core::length(m_observers[observer] - sum.point) * m_view.voxel_m);
    at(sum.bands, SightBand::kSeen) += 1;
    float& nearest = at(sum.bands, SightBand::kDistance);
    nearest = nearest == core::kNoData ? distance_m : std::min(nearest, distance_m);
}

SightLine SightEvaluator::line_to(std::size_t observer, core::Vec3 target) const noexcept {
    return {m_observers[observer], target, m_sag};
}

walk::TracedRay SightEvaluator::along(const SightLine& line, std::size_t observer,
                                      std::uint32_t chord, std::uint32_t sample) const noexcept {
    const core::Vec3 from = line.joint(chord);
    const core::Vec3 way = line.joint(chord + 1) - from;
    const double distance = core::length(way);
    walk::TracedRay out;
    out.kind = walk::RayKind::kSky;
    out.sample = sample;
    out.stream = chord * static_cast<std::uint32_t>(m_observers.size()) +
                 static_cast<std::uint32_t>(observer);
    out.t_max = distance;
    out.ray = {from, distance > 0 ? way * (1 / distance) : core::Vec3{0, 1, 0}};
    out.state = core::RayState(out.ray);
    // What lies outside of the world's bounds is free.
    if (!out.state.enter(m_view.cut.entry_bounds()) || out.state.t > out.t_max)
        out.end = walk::WalkEnd::kMiss;
    return out;
}

}  // namespace terravox::analyse
