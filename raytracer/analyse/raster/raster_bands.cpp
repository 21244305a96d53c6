#include "raytracer/analyse/raster/raster_bands.hpp"

#include <string>
#include <type_traits>

#include "common/util/error.hpp"

namespace terravox::analyse {
namespace {

template <class Band>
constexpr int measured_at(Band band) noexcept {
    static_assert(std::is_enum_v<Band>);
    return static_cast<int>(band);
}
constexpr int month_at(int month) noexcept {
    return measured_at(core::SunMonthsBand::kJanuary) + month - 1;
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
constexpr RasterBand kSunPeriodTable[] = {
    {"sun_hours", "h", measured_at(core::SunPeriodBand::kHours)},
    {"sun_hours_per_day", "h", measured_at(core::SunPeriodBand::kPerDay)},
    {"sun_share", "", measured_at(core::SunPeriodBand::kShare)},
    {"hole", "", measured_at(core::SunPeriodBand::kHole)},
};
constexpr RasterBand kSunMonthsTable[] = {
    {"sun_hours", "h", measured_at(core::SunMonthsBand::kHours)},
    {"january", "h", month_at(1)},
    {"february", "h", month_at(2)},
    {"march", "h", month_at(3)},
    {"april", "h", month_at(4)},
    {"may", "h", month_at(5)},
    {"june", "h", month_at(6)},
    {"july", "h", month_at(7)},
    {"august", "h", month_at(8)},
    {"september", "h", month_at(9)},
    {"october", "h", month_at(10)},
    {"november", "h", month_at(11)},
    {"december", "h", month_at(12)},
    {"hole", "", measured_at(core::SunMonthsBand::kHole)},
};
constexpr RasterBand kShadowTable[] = {
    {"sunlit", "", measured_at(core::ShadowBand::kSunlit)},
    {"hole", "", measured_at(core::ShadowBand::kHole)},
};
constexpr RasterBand kEnergyTable[] = {
    {"kwh_m2", "kWh/m2", measured_at(core::EnergyBand::kTotal)},
    {"beam", "kWh/m2", measured_at(core::EnergyBand::kBeam)},
    {"diffuse", "kWh/m2", measured_at(core::EnergyBand::kDiffuse)},
    {"reflected", "kWh/m2", measured_at(core::EnergyBand::kReflected)},
    {"slope", "degree", measured_at(core::EnergyBand::kSlope)},
    {"aspect", "degree", measured_at(core::EnergyBand::kAspect)},
    {"sun_hours", "h", measured_at(core::EnergyBand::kSunHours)},
    {"material", "", measured_at(core::EnergyBand::kMaterial)},
    {"hole", "", measured_at(core::EnergyBand::kHole)},
};
constexpr RasterBand kFacadeTable[] = {
    {"kwh_m2", "kWh/m2", measured_at(core::FacadeBand::kTotal)},
    {"beam", "kWh/m2", measured_at(core::FacadeBand::kBeam)},
    {"diffuse", "kWh/m2", measured_at(core::FacadeBand::kDiffuse)},
    {"reflected", "kWh/m2", measured_at(core::FacadeBand::kReflected)},
    {"sun_hours", "h", measured_at(core::FacadeBand::kSunHours)},
    {"sky_view", "", measured_at(core::FacadeBand::kSkyView)},
    {"azimuth", "degree", measured_at(core::FacadeBand::kAzimuth)},
    {"bottom", "m", measured_at(core::FacadeBand::kBottom)},
    {"height", "m", measured_at(core::FacadeBand::kHeight)},
    {"area", "m2", measured_at(core::FacadeBand::kArea)},
    {"hole", "", measured_at(core::FacadeBand::kHole)},
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
        case core::AnalysisKind::kNone:
        case core::AnalysisKind::kSunView: return {};
        case core::AnalysisKind::kTerrain: return kTerrainTable;
        case core::AnalysisKind::kSky: return kSkyTable;
        case core::AnalysisKind::kSun: return kSunTable;
        case core::AnalysisKind::kSunPeriod: return kSunPeriodTable;
        case core::AnalysisKind::kSunMonths: return kSunMonthsTable;
        case core::AnalysisKind::kShadow: return kShadowTable;
        case core::AnalysisKind::kEnergy: return kEnergyTable;
        case core::AnalysisKind::kFacade: return kFacadeTable;
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
