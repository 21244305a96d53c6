#include "raytracer/analyse/evaluators/evaluator.hpp"

#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/analyse/evaluators/energy_evaluator.hpp"
#include "raytracer/analyse/evaluators/facade_evaluator.hpp"
#include "raytracer/analyse/evaluators/sight.hpp"
#include "raytracer/analyse/evaluators/sky_evaluator.hpp"
#include "raytracer/analyse/evaluators/sun_evaluator.hpp"

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

walk::ThinThings thin_things(const shade::View& view) noexcept {
    const scene::Scene::Analysis& analysis = view.scene.analysis;
    const bool is_on_ground = analysis.surface == core::AnalysisSurface::kGround;
    bool may_pass = false;
    switch (analysis.kind) {
        case core::AnalysisKind::kNone:
        case core::AnalysisKind::kSunView:
        case core::AnalysisKind::kTerrain:
        case core::AnalysisKind::kSight: break;
        case core::AnalysisKind::kSky:
        case core::AnalysisKind::kSun:
        case core::AnalysisKind::kSunPeriod:
        case core::AnalysisKind::kSunMonths:
        case core::AnalysisKind::kShadow:
        case core::AnalysisKind::kEnergy: may_pass = is_on_ground; break;
        case core::AnalysisKind::kFacade: may_pass = true; break;
    }
    return may_pass && !analysis.thin_blocks ? walk::ThinThings::kPass : walk::ThinThings::kBlock;
}

}  // namespace terravox::analyse
