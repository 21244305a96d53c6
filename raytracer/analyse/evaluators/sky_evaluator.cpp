#include "raytracer/analyse/evaluators/sky_evaluator.hpp"

#include "raytracer/analyse/evaluators/bands.hpp"
#include "raytracer/analyse/evaluators/column_descent.hpp"
#include "raytracer/core/base/random.hpp"

namespace terravox::analyse {
namespace {

using core::SkyBand;

constexpr float kZenithAngle_deg = 90;

double range_of(const shade::View& view) noexcept {
    const double range_m = view.scene.analysis.range_m;
    return range_m > 0 ? range_m / view.voxel_m : core::kFar;
}

// By its place in the world, not in the raster: a cell has the same value in every raster.
std::uint64_t name_of_cell(core::Vec3 at) noexcept {
    constexpr double kSteps = 1024;  // column_descent places rays on this grid
    const auto x = static_cast<std::int64_t>(at.x * kSteps);
    const auto z = static_cast<std::int64_t>(at.z * kSteps);
    return core::hash64(static_cast<std::uint64_t>(x), static_cast<std::uint64_t>(z));
}

}  // namespace

SkyEvaluator::SkyEvaluator(const shade::View& view)
    : m_view(view),
      m_directions(view.scene.analysis.directions),
      m_fans(fan_of(m_directions.count() - 1) + 1),
      m_range(range_of(view)) {}

void SkyEvaluator::shade(const walk::TracedRay& ray, shade::SampleSum& sum,
                         std::vector<walk::TracedRay>& next) const {
    sum.bands = no_values(SkyBand::kHole, is_hole(ray));
    switch (cell_step_at(ray, m_view.scene.analysis.surface)) {
        case CellStep::kMeasure:
            sum.bands = {};
            send_to_sky(start_above(ray), SkyDirections::set_of(name_of_cell(ray.ray.origin)), 0,
                        next);
            break;
        case CellStep::kDescend: next.push_back(below(ray)); break;
        case CellStep::kNothing: break;
    }
}

SkyEvaluator::Part SkyEvaluator::part_of(std::uint32_t stream) const noexcept {
    const std::size_t first = stream % m_fans * walk::kFanRays;
    return {stream / m_fans, first, fan_end(first, m_directions.count())};
}

walk::FanDirections SkyEvaluator::directions(std::uint32_t stream) const {
    const Part part = part_of(stream);
    walk::FanDirections out;
    for (std::size_t i = part.first; i < part.end; ++i)
        out.add(m_directions.of(part.set)[i].to);
    return out;
}

void SkyEvaluator::shade_fan(const walk::TracedRay& fan, walk::FanEnds ends, shade::SampleSum& sum,
                             std::vector<walk::TracedRay>& next) const {
    if (ends.holes != 0) {
        sum.bands = no_values(SkyBand::kHole, true);
        return;
    }
    const Part part = part_of(fan.stream);
    const auto directions = m_directions.of(part.set);
    const walk::FanMask free = free_rays(fan, ends, *this, m_view);
    for (std::size_t i = part.first; i < part.end; ++i) {
        if (!walk::has(free, i - part.first))
            continue;
        const voxel::Colour& share = directions[i].share;
        at(sum.bands, SkyBand::kCosine) += share.r;
        at(sum.bands, SkyBand::kSolid) += share.g;
        at(sum.bands, SkyBand::kOpenness) += share.b * kZenithAngle_deg;
    }
    if (part.end < directions.size())
        send_to_sky(start_of(fan), part.set, part.end, next);
}

void SkyEvaluator::send_to_sky(const FanStart& start, std::size_t set, std::size_t first,
                               std::vector<walk::TracedRay>& next) const {
    const std::size_t end = fan_end(first, m_directions.count());
    walk::TracedRay& fan = add_fan(start, walk::RayKind::kSky, walk::mask_of_first(end - first),
                                   static_cast<std::uint32_t>(set) * m_fans + fan_of(first), next);
    fan.t_max = m_range;
}

}  // namespace terravox::analyse
