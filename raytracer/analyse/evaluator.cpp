#include "raytracer/analyse/evaluator.hpp"

#include "raytracer/analyse/energy_evaluator.hpp"
#include "raytracer/analyse/facade_evaluator.hpp"
#include "raytracer/analyse/sight_evaluator.hpp"
#include "raytracer/analyse/sky_evaluator.hpp"
#include "raytracer/analyse/sun_evaluator.hpp"
#include "raytracer/analyse/sun_view_evaluator.hpp"
#include "raytracer/analyse/terrain_evaluator.hpp"

namespace terravox::analyse {

std::unique_ptr<const shade::RayEvaluator> make_evaluator(const shade::View& view) {
    switch (view.scene.analysis.kind) {
        case core::AnalysisKind::kNone: break;
        case core::AnalysisKind::kTerrain: return std::make_unique<TerrainEvaluator>(view);
        case core::AnalysisKind::kSky: return std::make_unique<SkyEvaluator>(view);
        case core::AnalysisKind::kSun:
        case core::AnalysisKind::kSunPeriod:
        case core::AnalysisKind::kSunMonths:
        case core::AnalysisKind::kShadow: return std::make_unique<SunEvaluator>(view);
        case core::AnalysisKind::kSunView: return std::make_unique<SunViewEvaluator>(view);
        case core::AnalysisKind::kEnergy: return std::make_unique<EnergyEvaluator>(view);
        case core::AnalysisKind::kFacade: return std::make_unique<FacadeEvaluator>(view);
        case core::AnalysisKind::kSight: return std::make_unique<SightEvaluator>(view);
    }
    return shade::make_shading(view);
}

}  // namespace terravox::analyse
