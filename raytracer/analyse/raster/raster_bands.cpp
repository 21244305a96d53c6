#include "raytracer/analyse/raster/raster_bands.hpp"

#include <string>

#include "common/util/error.hpp"

namespace terravox::analyse {
namespace {

constexpr int measured_at(core::TerrainBand band) noexcept {
    return static_cast<int>(band);
}
constexpr int measured_at(core::SkyBand band) noexcept {
    return static_cast<int>(band);
}
constexpr int measured_at(core::SunBand band) noexcept {
    return static_cast<int>(band);
}
constexpr int measured_at(core::SightBand band) noexcept {
    return static_cast<int>(band);
}

constexpr RasterBand kTerrainTable[] = {
    {"dsm", "m", measured_at(core::TerrainBand::kSurface)},
    {"dtm", "m", measured_at(core::TerrainBand::kGround)},
    {"ndsm", "m", kDerived},
    {"slope", "degree", kDerived},
    {"aspect", "degree", kDerived},
    {"hillshade", "", kDerived},
    {"class", "", measured_at(core::TerrainBand::kClass)},
    {"material", "", measured_at(core::TerrainBand::kMaterial)},
    {"red", "", measured_at(core::TerrainBand::kRed)},
    {"green", "", measured_at(core::TerrainBand::kGreen)},
    {"blue", "", measured_at(core::TerrainBand::kBlue)},
    {"dtm_source", "", kDerived},
    {"hole", "", measured_at(core::TerrainBand::kHole)},
};
constexpr RasterBand kSkyTable[] = {
    {"svf", "", measured_at(core::SkyBand::kCosine)},
    {"sky_view_solid", "", measured_at(core::SkyBand::kSolid)},
    {"openness", "degree", measured_at(core::SkyBand::kOpenness)},
    {"hole", "", measured_at(core::SkyBand::kHole)},
};
constexpr RasterBand kSunTable[] = {
    {"sun_hours", "h", measured_at(core::SunBand::kHours)},
    {"first_sun", "h", measured_at(core::SunBand::kFirst)},
    {"last_sun", "h", measured_at(core::SunBand::kLast)},
    {"hole", "", measured_at(core::SunBand::kHole)},
};
constexpr RasterBand kSightTable[] = {
    {"seen", "", measured_at(core::SightBand::kSeen)},
    {"distance_m", "m", measured_at(core::SightBand::kDistance)},
    {"class", "", measured_at(core::SightBand::kClass)},
    {"material", "", measured_at(core::SightBand::kMaterial)},
    {"hole", "", measured_at(core::SightBand::kHole)},
};

}  // namespace

std::span<const RasterBand> bands_of(core::AnalysisKind kind) noexcept {
    switch (kind) {
        case core::AnalysisKind::kNone: return {};
        case core::AnalysisKind::kTerrain: return kTerrainTable;
        case core::AnalysisKind::kSky: return kSkyTable;
        case core::AnalysisKind::kSun: return kSunTable;
        case core::AnalysisKind::kSight: return kSightTable;
    }
    return {};
}

int band_number(core::AnalysisKind kind, std::string_view name) {
    int number = 0;
    for (const RasterBand& band : bands_of(kind)) {
        ++number;
        if (band.name == name)
            return number;
    }
    throw util::Error("find the band " + std::string(name) + ": the analysis has none");
}

}  // namespace terravox::analyse
