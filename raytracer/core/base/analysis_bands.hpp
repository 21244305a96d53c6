#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "raytracer/core/base/scene_words.hpp"

namespace terravox::core {

/// Stands for no value in a band of an analysis: outside of the data, or behind a hole.
inline constexpr float kNoData = -9999;

/// What rays measure for a cell, one float for each. The numbers are those of a tile's planes.
enum class TerrainBand : std::uint8_t {
    kSurface,  ///< top of the highest voxel, metres
    kGround,   ///< top of the ground, metres; kNoData where it is covered
    kClass,    ///< of the survey, of the highest voxel
    kMaterial,
    kRed,  ///< sRGB, 0 to 255
    kGreen,
    kBlue,
    kHole,  ///< 1: a box that is not available; all other bands are kNoData
};
inline constexpr std::size_t kTerrainBands = 8;

enum class SkyBand : std::uint8_t {
    kCosine,    ///< sky-view factor: share of the sky's light on a level surface, [0, 1]
    kSolid,     ///< share of the solid angle above the horizon, [0, 1]
    kOpenness,  ///< mean over all azimuths of the free zenith angle, degrees, [0, 90]
    kHole,      ///< as TerrainBand::kHole
};
inline constexpr std::size_t kSkyBands = 4;

enum class SunBand : std::uint8_t {
    kHours,  ///< of direct sun
    kFirst,  ///< clock time at which the first sunlit step begins, hours
    kLast,   ///< clock time at which the last one ends
    kHole,   ///< as TerrainBand::kHole
};
inline constexpr std::size_t kSunBands = 4;

enum class SightBand : std::uint8_t {
    kSeen,      ///< number of observers that see the cell
    kDistance,  ///< to the nearest of those, metres; kNoData where there is none
    kClass,     ///< of the survey, of the voxel that is looked for
    kMaterial,
    kHole,  ///< as TerrainBand::kHole
};
inline constexpr std::size_t kSightBands = 5;

enum class SunPeriodBand : std::uint8_t {
    kHours,   ///< of direct sun in the period
    kPerDay,  ///< its mean over the days of the period, hours
    kShare,   ///< of the time for which the sun is above a level horizon, [0, 1]
    kHole,    ///< as TerrainBand::kHole
};
inline constexpr std::size_t kSunPeriodBands = 4;

enum class SunMonthsBand : std::uint8_t {
    kHours,      ///< of direct sun in the period
    kJanuary,    ///< hours of all Januaries in the period; those of February follow, ...
    kHole = 13,  ///< as TerrainBand::kHole
};
inline constexpr std::size_t kSunMonthsBands = 14;

enum class ShadowBand : std::uint8_t {
    kSunlit,  ///< 1: in the sun; 0: in shadow, or the sun is below the horizon
    kHole,    ///< as TerrainBand::kHole
};
inline constexpr std::size_t kShadowBands = 2;

enum class EnergyBand : std::uint8_t {
    kHole,   ///< as TerrainBand::kHole
    kTotal,  ///< of all that follows, kWh/m2 of the surface
    kBeam,
    kDiffuse,
    kReflected,
    kSlope,     ///< of the surface that the energy is of, degrees
    kAspect,    ///< where it falls to, degrees clockwise from north; kNoData where it is level
    kSunHours,  ///< for which the sun shines on the surface
    kMaterial,  ///< of the voxel that is measured; has a value behind a hole, too
};
inline constexpr std::size_t kEnergyBands = 9;

/// Of the wall between a cell of a building and a lower neighbour; core::kNoData: none.
enum class FacadeBand : std::uint8_t {
    kHole,   ///< as TerrainBand::kHole
    kTotal,  ///< of all that follows, kWh/m2 of the wall
    kBeam,
    kDiffuse,
    kReflected,
    kSunHours,  ///< for which the sun shines on the wall
    kSkyView,   ///< share of the light of an even sky, [0, 0.5]
    kAzimuth,   ///< where the wall looks to, degrees clockwise from the map's north
    kBottom,    ///< of the storey, metres
    kHeight,    ///< of the storey's wall, metres
    kArea,      ///< of the wall, m2: less than the face of the voxels where the wall is oblique
};
inline constexpr std::size_t kFacadeBands = 11;

inline constexpr std::size_t kMaxBands = 16;
static_assert(kTerrainBands <= kMaxBands && kSkyBands <= kMaxBands && kSunBands <= kMaxBands &&
              kSunPeriodBands <= kMaxBands && kSunMonthsBands <= kMaxBands &&
              kShadowBands <= kMaxBands && kEnergyBands <= kMaxBands && kFacadeBands <= kMaxBands &&
              kSightBands <= kMaxBands);

/// @return 0: a picture, which has no bands
[[nodiscard]] constexpr std::size_t band_count(AnalysisKind kind) noexcept {
    switch (kind) {
        case AnalysisKind::kNone:
        case AnalysisKind::kSunView: return 0;
        case AnalysisKind::kTerrain: return kTerrainBands;
        case AnalysisKind::kSky: return kSkyBands;
        case AnalysisKind::kSun: return kSunBands;
        case AnalysisKind::kSunPeriod: return kSunPeriodBands;
        case AnalysisKind::kSunMonths: return kSunMonthsBands;
        case AnalysisKind::kShadow: return kShadowBands;
        case AnalysisKind::kEnergy: return kEnergyBands;
        case AnalysisKind::kFacade: return kFacadeBands;
        case AnalysisKind::kSight: return kSightBands;
    }
    return 0;
}

/// The measured bands of one cell; those beyond its analysis are not used.
using Bands = std::array<float, kMaxBands>;

}  // namespace terravox::core
