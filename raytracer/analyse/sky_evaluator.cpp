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

walk::TracedRay SkyEvaluator::primary(const core::Ray& ray, std::uint32_t sample) const noexcept {
    return cell_ray(ray, sample);
}

bool SkyEvaluator::needs_surroundings(const walk::TracedRay& /*ray*/) const noexcept {
    return false;
}

void SkyEvaluator::shade(const walk::TracedRay& ray, shade::SampleSum& sum,
                         std::vector<walk::TracedRay>& next) const {
    if (ray.kind == walk::RayKind::kPrimary) {
        shade_cell(ray, sum, next);
        return;
    }
    if (at(sum.bands, SkyBand::kHole) > 0)
        return;
    if (ray.end == walk::WalkEnd::kHit) {
        if (ray.hit.hole)
            sum.bands = no_values(SkyBand::kHole, true);
        return;
    }
    at(sum.bands, SkyBand::kCosine) += ray.weight.r;
    at(sum.bands, SkyBand::kSolid) += ray.weight.g;
    at(sum.bands, SkyBand::kOpenness) += ray.weight.b * kZenithAngle_deg;
}

void SkyEvaluator::shade_cell(const walk::TracedRay& ray, shade::SampleSum& sum,
                              std::vector<walk::TracedRay>& next) const {
    const bool hit = ray.end == walk::WalkEnd::kHit;
    sum.bands = no_values(SkyBand::kHole, hit && ray.hit.hole);
    if (!hit || ray.hit.hole)
        return;
    if (m_view.scene.analysis.surface == core::AnalysisSurface::kTop) {
        send_to_sky(ray, sum, next);
        return;
    }
    switch (descent_at(ray)) {
        case Descent::kGround: send_to_sky(ray, sum, next); break;
        case Descent::kCovered: break;
        case Descent::kContinues: next.push_back(below(ray)); break;
    }
}

void SkyEvaluator::send_to_sky(const walk::TracedRay& ray, shade::SampleSum& sum,
                               std::vector<walk::TracedRay>& next) const {
    at(sum.bands, SkyBand::kCosine) = 0;
    at(sum.bands, SkyBand::kSolid) = 0;
    at(sum.bands, SkyBand::kOpenness) = 0;
    const core::VoxelCoord start{ray.hit.voxel.x, ray.hit.voxel.y + 1, ray.hit.voxel.z};
    const core::Vec3 origin{ray.ray.origin.x, top_of(ray.hit), ray.ray.origin.z};
    for (const SkyDirection& direction : m_directions.of(name_of_cell(origin))) {
        walk::TracedRay out;
        out.ray = {origin, direction.to};
        out.state = core::RayState(out.ray);
        out.state.start_in(start, ray.hit.level);
        out.weight = direction.share;
        out.sample = ray.sample;
        out.kind = walk::RayKind::kSky;
        out.t_max = m_range;
        next.push_back(out);
    }
}

}  // namespace terravox::analyse
