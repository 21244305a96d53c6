#include "raytracer/analyse/sun_evaluator.hpp"

#include <algorithm>

#include "raytracer/analyse/bands.hpp"
#include "raytracer/analyse/column_descent.hpp"

namespace terravox::analyse {
namespace {

using core::SunBand;

}  // namespace

walk::TracedRay SunEvaluator::primary(const core::Ray& ray, std::uint32_t sample) const noexcept {
    return cell_ray(ray, sample);
}

bool SunEvaluator::needs_surroundings(const walk::TracedRay& /*ray*/) const noexcept {
    return false;
}

void SunEvaluator::shade(const walk::TracedRay& ray, shade::SampleSum& sum,
                         std::vector<walk::TracedRay>& next) const {
    if (ray.kind != walk::RayKind::kPrimary) {
        if (at(sum.bands, SunBand::kHole) > 0)
            return;
        if (ray.end != walk::WalkEnd::kHit)
            add_sunlit_step(ray.stream, sum.bands);
        else if (ray.hit.hole)
            sum.bands = no_values(SunBand::kHole, true);
        return;
    }
    sum.bands = no_values(SunBand::kHole, is_hole(ray));
    switch (cell_step_at(ray, m_view.scene.analysis.surface)) {
        case CellStep::kMeasure: send_to_sun(ray, sum, next); break;
        case CellStep::kDescend: next.push_back(below(ray)); break;
        case CellStep::kNothing: break;
    }
}

void SunEvaluator::add_sunlit_step(std::size_t step, core::Bands& bands) const noexcept {
    const double half_h = m_view.scene.analysis.step_min / 60 / 2;
    const double middle_h = m_view.sun_steps[step].hour;
    const auto begin = static_cast<float>(middle_h - half_h);
    const auto end = static_cast<float>(middle_h + half_h);
    at(bands, SunBand::kHours) += static_cast<float>(2 * half_h);
    float& first = at(bands, SunBand::kFirst);
    float& last = at(bands, SunBand::kLast);
    first = first == core::kNoData ? begin : std::min(first, begin);
    last = std::max(last, end);
}

void SunEvaluator::send_to_sun(const walk::TracedRay& ray, shade::SampleSum& sum,
                               std::vector<walk::TracedRay>& next) const {
    at(sum.bands, SunBand::kHours) = 0;
    for (std::size_t step = 0; step < m_view.sun_steps.size(); ++step) {
        walk::TracedRay out = upward(ray, m_view.sun_steps[step].to);
        out.stream = static_cast<std::uint32_t>(step);
        next.push_back(out);
    }
}

}  // namespace terravox::analyse
