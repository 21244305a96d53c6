#include "raytracer/analyse/sun_evaluator.hpp"

#include <algorithm>

#include "raytracer/analyse/bands.hpp"
#include "raytracer/analyse/column_descent.hpp"

namespace terravox::analyse {
namespace {

using core::AnalysisKind;
using core::ShadowBand;
using core::SunBand;
using core::SunMonthsBand;
using core::SunPeriodBand;

void add_to_day(const solar::SunDirection& from, core::Bands& bands) noexcept {
    const auto begin = static_cast<float>(from.begin_h);
    const auto end = static_cast<float>(from.end_h);
    at(bands, SunBand::kHours) += static_cast<float>(from.hours);
    float& first = at(bands, SunBand::kFirst);
    float& last = at(bands, SunBand::kLast);
    first = first == core::kNoData ? begin : std::min(first, begin);
    last = std::max(last, end);
}

void add_to_period(const solar::SunDirection& from, const solar::SunWay& way,
                   core::Bands& bands) noexcept {
    at(bands, SunPeriodBand::kHours) += static_cast<float>(from.hours);
    at(bands, SunPeriodBand::kPerDay) += static_cast<float>(from.hours / way.days);
    at(bands, SunPeriodBand::kShare) += static_cast<float>(from.hours / way.hours);
}

void add_to_months(const solar::SunDirection& from, core::Bands& bands) noexcept {
    at(bands, SunMonthsBand::kHours) += static_cast<float>(from.hours);
    float* const month = &at(bands, SunMonthsBand::kJanuary);
    for (std::size_t m = 0; m < from.month_hours.size(); ++m)
        month[m] += from.month_hours[m];
}

/// The band that counts holes: the last one of every kind.
std::size_t hole_of(AnalysisKind kind) noexcept {
    return core::band_count(kind) - 1;
}

}  // namespace

void SunEvaluator::shade(const walk::TracedRay& ray, shade::SampleSum& sum,
                         std::vector<walk::TracedRay>& next) const {
    if (ray.kind == walk::RayKind::kPrimary) {
        shade_cell(ray, sum, next);
        return;
    }
    const std::size_t hole = hole_of(m_view.scene.analysis.kind);
    if (sum.bands[hole] > 0)
        return;
    if (is_hole(ray))
        sum.bands = no_values(hole, true);
    else if (is_free(ray, m_view))
        add_sunlit(m_view.sun_way.directions[ray.stream], sum.bands);
    if (ends_chunk(ray.stream))
        send_to_sun(ray, ray.stream + 1, next);
}

void SunEvaluator::shade_cell(const walk::TracedRay& ray, shade::SampleSum& sum,
                              std::vector<walk::TracedRay>& next) const {
    sum.bands = no_values(hole_of(m_view.scene.analysis.kind), is_hole(ray));
    switch (cell_step_at(ray, m_view.scene.analysis.surface)) {
        case CellStep::kMeasure:
            sum.bands = without_sun();
            send_to_sun(ray, 0, next);
            break;
        case CellStep::kDescend: next.push_back(below(ray)); break;
        case CellStep::kNothing: break;
    }
}

core::Bands SunEvaluator::without_sun() const noexcept {
    core::Bands out{};
    if (m_view.scene.analysis.kind == AnalysisKind::kSun) {
        at(out, SunBand::kFirst) = core::kNoData;
        at(out, SunBand::kLast) = core::kNoData;
    }
    return out;
}

void SunEvaluator::add_sunlit(const solar::SunDirection& from, core::Bands& bands) const noexcept {
    switch (m_view.scene.analysis.kind) {
        case AnalysisKind::kSun: add_to_day(from, bands); break;
        case AnalysisKind::kSunPeriod: add_to_period(from, m_view.sun_way, bands); break;
        case AnalysisKind::kSunMonths: add_to_months(from, bands); break;
        case AnalysisKind::kShadow: at(bands, ShadowBand::kSunlit) = 1; break;
        case AnalysisKind::kNone:
        case AnalysisKind::kSunView:
        case AnalysisKind::kTerrain:
        case AnalysisKind::kEnergy:
        case AnalysisKind::kFacade:
        case AnalysisKind::kSight:
        case AnalysisKind::kSky: break;
    }
}

void SunEvaluator::send_to_sun(const walk::TracedRay& ray, std::size_t first,
                               std::vector<walk::TracedRay>& next) const {
    const auto& directions = m_view.sun_way.directions;
    for (std::size_t i = first; i < chunk_end(first, directions.size()); ++i) {
        walk::TracedRay& out = add_upward(ray, directions[i].to, next);
        out.kind = walk::RayKind::kShadow;
        out.stream = static_cast<std::uint32_t>(i);
    }
}

}  // namespace terravox::analyse
