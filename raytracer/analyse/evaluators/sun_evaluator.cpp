#include "raytracer/analyse/evaluators/sun_evaluator.hpp"

#include <algorithm>

#include "raytracer/analyse/evaluators/cell_evaluator.hpp"

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
std::size_t find_hole(AnalysisKind kind) noexcept {
    return core::band_count(kind) - 1;
}

}  // namespace

void SunEvaluator::shade(const walk::TracedRay& ray, shade::SampleSum& sum,
                         std::vector<walk::TracedRay>& next) const {
    sum.bands = no_values(find_hole(m_view.scene.analysis.kind), is_hole(ray));
    switch (cell_step_at(ray, m_view.scene.analysis.surface)) {
        case CellStep::kMeasure:
            sum.bands = without_sun();
            send_to_sun(start_above(ray), 0, next);
            break;
        case CellStep::kDescend: next.push_back(below(ray)); break;
        case CellStep::kNothing: break;
    }
}

walk::FanDirections SunEvaluator::directions(std::uint32_t stream) const {
    const auto& all = m_view.sun_way.directions;
    const std::size_t first = stream * walk::kFanRays;
    walk::FanDirections out;
    for (std::size_t i = first; i < fan_end(first, all.size()); ++i)
        out.add(all[i].to);
    return out;
}

void SunEvaluator::shade_fan(const walk::TracedRay& fan, walk::FanEnds ends, shade::SampleSum& sum,
                             std::vector<walk::TracedRay>& next) const {
    if (ends.holes != 0) {
        sum.bands = no_values(find_hole(m_view.scene.analysis.kind), true);
        return;
    }
    const auto& all = m_view.sun_way.directions;
    const std::size_t first = fan.stream * walk::kFanRays;
    const std::size_t end = fan_end(first, all.size());
    const walk::FanMask free = free_rays(fan, ends, *this, m_view);
    for (std::size_t i = first; i < end; ++i)
        if (walk::has(free, i - first))
            add_sunlit(all[i], sum.bands);
    send_to_sun(find_start(fan), end, next);
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

void SunEvaluator::send_to_sun(const FanStart& start, std::size_t first,
                               std::vector<walk::TracedRay>& next) const {
    const std::size_t end = fan_end(first, m_view.sun_way.directions.size());
    if (first < end)
        add_fan(start, walk::RayKind::kShadow, walk::mask_of_first(end - first), to_fan(first),
                next);
}

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
    const core::Vec3 normal = core::to_normal(ray.hit.face);
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
