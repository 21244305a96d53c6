#include "raytracer/apps/commands/analyse/own_fields.hpp"

namespace terravox::commands {

std::vector<std::string> own_fields(core::AnalysisKind kind) {
    switch (kind) {
        case core::AnalysisKind::kTerrain:
            return {"analysis.relief", "analysis.window", "analysis.fill_m",
                    "analysis.relief_light"};
        case core::AnalysisKind::kSky:
            return {"analysis.surface", "analysis.thin_blocks", "analysis.directions",
                    "analysis.range_m"};
        case core::AnalysisKind::kShadow:
            return {"analysis.surface", "analysis.thin_blocks", "sun.date", "sun.time_h",
                    "sun.zone",         "sun.utc_offset_h"};
        case core::AnalysisKind::kSun:
        case core::AnalysisKind::kSunPeriod:
        case core::AnalysisKind::kSunMonths:
            return {
                "analysis.surface", "analysis.thin_blocks", "analysis.step_min", "analysis.from",
                "analysis.to",      "analysis.bin_deg",     "sun.date",          "sun.zone",
                "sun.utc_offset_h"};
        case core::AnalysisKind::kEnergy:
            return {"analysis.surface",
                    "analysis.thin_blocks",
                    "analysis.directions",
                    "analysis.step_min",
                    "analysis.from",
                    "analysis.to",
                    "analysis.bin_deg",
                    "analysis.linke",
                    "analysis.diffuse",
                    "analysis.albedo",
                    "analysis.crown_light",
                    "analysis.storey_m",
                    "sun.date",
                    "sun.zone",
                    "sun.utc_offset_h"};
        case core::AnalysisKind::kSight:
            return {"analysis.surface", "analysis.range_m", "analysis.target_m",
                    "analysis.curvature", "analysis.refraction"};
        default: return {};
    }
}

}  // namespace terravox::commands
