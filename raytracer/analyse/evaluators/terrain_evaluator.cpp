#include "raytracer/analyse/evaluators/terrain_evaluator.hpp"

#include <cmath>

#include "raytracer/analyse/evaluators/bands.hpp"
#include "raytracer/analyse/evaluators/column_descent.hpp"

namespace terravox::analyse {
namespace {

using core::TerrainBand;

float byte_of(float linear) noexcept {
    return std::floor(voxel::linear_to_srgb(linear) * 255 + 0.5F);
}

}  // namespace

void TerrainEvaluator::note_surface(const walk::Hit& hit, core::Bands& bands) const noexcept {
    at(bands, TerrainBand::kSurface) = static_cast<float>(top_of(hit) * m_view.voxel_m);
    at(bands, TerrainBand::kClass) = hit.attr.source_class;
    at(bands, TerrainBand::kMaterial) = static_cast<float>(hit.attr.material);
    if (hit.attr.has_colour()) {
        at(bands, TerrainBand::kRed) = hit.attr.colour.r;
        at(bands, TerrainBand::kGreen) = hit.attr.colour.g;
        at(bands, TerrainBand::kBlue) = hit.attr.colour.b;
        return;
    }
    const voxel::Colour colour = m_view.materials->appearance(hit.attr.material).colour;
    at(bands, TerrainBand::kRed) = byte_of(colour.r);
    at(bands, TerrainBand::kGreen) = byte_of(colour.g);
    at(bands, TerrainBand::kBlue) = byte_of(colour.b);
}

void TerrainEvaluator::shade(const walk::TracedRay& ray, shade::SampleSum& sum,
                             std::vector<walk::TracedRay>& next) const {
    const bool is_first = ray.depth == 0;
    if (is_first)
        sum.bands = no_values(TerrainBand::kHole, false);
    if (ray.end != walk::WalkEnd::kHit)
        return;
    if (ray.hit.hole) {
        sum.bands = no_values(TerrainBand::kHole, true);
        return;
    }
    if (is_first)
        note_surface(ray.hit, sum.bands);
    switch (descent_at(ray)) {
        case Descent::kGround:
            at(sum.bands, TerrainBand::kGround) =
                static_cast<float>(top_of(ray.hit) * m_view.voxel_m);
            break;
        case Descent::kCovered: break;
        case Descent::kContinues: next.push_back(below(ray)); break;
    }
}

}  // namespace terravox::analyse
