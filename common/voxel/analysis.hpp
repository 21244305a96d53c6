#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace terravox::voxel {

/// What a pixel is: light, or measured values of a cell of a raster (docs/adr/0029).
enum class AnalysisKind : std::uint8_t {
    kNone,       ///< a picture
    kTerrain,    ///< heights, classes, materials, colours
    kSky,        ///< how much of the sky is seen
    kSun,        ///< hours of direct sun on a day
    kSunPeriod,  ///< hours of direct sun in a period
    kSunMonths,  ///< the same, and by month
    kShadow,     ///< whether the sun shines at an instant
    kSunView,    ///< hours of direct sun on a day, as a camera sees them: pixels, no bands
    kEnergy,     ///< energy of the sun and of the sky
    kFacade,     ///< the same, on the walls of one side and storey
    kSight,      ///< what observers see
    kClearance,  ///< the free height above the ground
};

/// Paths of fields of a scene; what is empty is none.
using SceneFields = std::array<std::string_view, 16>;

/// What may be asked of an analysis: scenes, commands, jobs over HTTP and help follow. How it is
/// measured is in raytracer/analyse/evaluators.
struct AnalysisTerms {
    AnalysisKind kind;
    std::string_view name;  ///< the word that stands for it
    std::string_view help;  ///< of its command; empty: it has none, another one's options choose it
    /// A few words by which it is offered where a job is chosen; empty where `help` is.
    std::string_view title = {};
    /// Paths of the scene's fields that it reads, in addition to those of all.
    SceneFields fields = {};

    [[nodiscard]] bool reads(std::string_view field) const noexcept {
        return std::find(fields.begin(), fields.end(), field) != fields.end();
    }
};

inline constexpr SceneFields kFieldsOfSunHours = {
    {"analysis.surface", "analysis.thin_blocks", "analysis.step_min", "analysis.from",
     "analysis.to", "analysis.bin_deg", "sun.date", "sun.zone", "sun.utc_offset_h"}};

inline constexpr AnalysisTerms kAnalyses[] = {
    {AnalysisKind::kNone, "none", ""},
    {AnalysisKind::kTerrain,
     "terrain",
     "Heights of surface and ground, slope, aspect, hillshade, class, material, colour",
     "Terrain: heights, slopes",
     {{"analysis.relief", "analysis.window", "analysis.fill_m", "analysis.relief_light"}}},
    {AnalysisKind::kSky,
     "sky",
     "How much of the sky is seen: sky-view factor, openness",
     "How much sky is seen",
     {{"analysis.surface", "analysis.thin_blocks", "analysis.directions", "analysis.range_m"}}},
    {AnalysisKind::kSun, "sun",
     "Hours of direct sun on a day or in a period, or where it shines at an instant",
     "Hours of sun", kFieldsOfSunHours},
    {AnalysisKind::kSunPeriod, "sun-period", "", "", kFieldsOfSunHours},
    {AnalysisKind::kSunMonths, "sun-months", "", "", kFieldsOfSunHours},
    {AnalysisKind::kShadow,
     "shadow",
     "",
     "",
     {{"analysis.surface", "analysis.thin_blocks", "sun.date", "sun.time_h", "sun.zone",
       "sun.utc_offset_h"}}},
    {AnalysisKind::kSunView, "sun-view", ""},
    {AnalysisKind::kEnergy,
     "energy",
     "Energy of sun and sky on a day or in a period, on roofs and ground as they lie",
     "Energy of the sun",
     {{"analysis.surface", "analysis.thin_blocks", "analysis.directions", "analysis.step_min",
       "analysis.from", "analysis.to", "analysis.bin_deg", "analysis.linke", "analysis.diffuse",
       "analysis.albedo", "analysis.crown_light", "analysis.storey_m", "sun.date", "sun.zone",
       "sun.utc_offset_h"}}},
    {AnalysisKind::kFacade, "facade", ""},
    {AnalysisKind::kSight,
     "sight",
     "What observers see, and from where they are seen: viewsheds",
     "Seen from a place",
     {{"analysis.surface", "analysis.range_m", "analysis.target_m", "analysis.curvature",
       "analysis.refraction"}}},
    {AnalysisKind::kClearance, "clearance",
     "Free height above the ground, below decks, wires and crowns", "Free height"},
};

[[nodiscard]] inline const AnalysisTerms& find_terms(AnalysisKind kind) noexcept {
    return *std::find_if(std::begin(kAnalyses), std::end(kAnalyses),
                         [&](const AnalysisTerms& terms) { return terms.kind == kind; });
}

/// The names of those that have a command, in the order of the table.
[[nodiscard]] inline std::vector<std::string> list_analyses() {
    std::vector<std::string> out;
    for (const AnalysisTerms& terms : kAnalyses)
        if (!terms.help.empty())
            out.emplace_back(terms.name);
    return out;
}

}  // namespace terravox::voxel
