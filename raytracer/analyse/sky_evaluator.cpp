#include "raytracer/analyse/sky_evaluator.hpp"

#include "raytracer/analyse/bands.hpp"
#include "raytracer/analyse/column_descent.hpp"
#include "raytracer/core/random.hpp"

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
    : m_view(view), m_directions(view.scene.analysis.directions), m_range(range_of(view)) {}

void SkyEvaluator::shade(const walk::TracedRay& ray, shade::SampleSum& sum,
                         std::vector<walk::TracedRay>& next) const {
    if (ray.kind == walk::RayKind::kPrimary) {
        shade_cell(ray, sum, next);
        return;
    }
    if (at(sum.bands, SkyBand::kHole) > 0)
        return;
    if (is_hole(ray)) {
        sum.bands = no_values(SkyBand::kHole, true);
    } else if (is_free(ray, m_view)) {
        at(sum.bands, SkyBand::kCosine) += ray.weight.r;
        at(sum.bands, SkyBand::kSolid) += ray.weight.g;
        at(sum.bands, SkyBand::kOpenness) += ray.weight.b * kZenithAngle_deg;
    }
    const std::size_t index = ray.stream % m_directions.count();
    if (ends_chunk(index))
        send_to_sky(ray, index + 1, next);
}

void SkyEvaluator::shade_cell(const walk::TracedRay& ray, shade::SampleSum& sum,
                              std::vector<walk::TracedRay>& next) const {
    sum.bands = no_values(SkyBand::kHole, is_hole(ray));
    switch (cell_step_at(ray, m_view.scene.analysis.surface)) {
        case CellStep::kMeasure:
            sum.bands = {};
            send_to_sky(ray, 0, next);
            break;
        case CellStep::kDescend: next.push_back(below(ray)); break;
        case CellStep::kNothing: break;
    }
}

void SkyEvaluator::send_to_sky(const walk::TracedRay& ray, std::size_t first,
                               std::vector<walk::TracedRay>& next) const {
    const std::size_t set = SkyDirections::set_of(name_of_cell(ray.ray.origin));
    const auto directions = m_directions.of(set);
    for (std::size_t i = first; i < chunk_end(first, directions.size()); ++i) {
        walk::TracedRay& out = add_upward(ray, directions[i].to, next);
        out.weight = directions[i].share;
        out.t_max = m_range;
        out.stream = static_cast<std::uint32_t>(set * directions.size() + i);
    }
}

}  // namespace terravox::analyse
