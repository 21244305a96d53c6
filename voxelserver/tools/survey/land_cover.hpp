#pragma once

#include <cstdint>

#include "voxelserver/tools/survey/plane.hpp"

namespace terravox::survey {

/// What lies on the ground; one byte for each square metre of a square.
enum class Cover : std::uint8_t {
    kMeadow,
    kMownMeadow,
    kWheat,
    kBarley,
    kMaize,
    kRape,
    kPloughed,  // the parcels of the valley
    kGarden,
    kForest,
    kScrub,
    kRock,
    kBeach,
    kRoad,
    kGravelRoad,
    kCourtyard,
    kBuilding,
};

/// The site properties that determine the cover.
struct CoverSite {
    Vec2 at;
    double ground_m = 0;
    double slope = 0;           ///< rise over run
    double above_valley_m = 0;  ///< over the level of the nearest river
    double to_street_m = 1e9;   ///< to the centre line of the nearest street with houses
    double to_water_m = 1e9;    ///< only set near lakes: metres to the shore
    bool island = false;
};

/// The cover of land without road, building or water. A function of seed and site only.
[[nodiscard]] Cover natural_cover(std::uint64_t seed, const CoverSite& site) noexcept;

/// The parcel that a point of the valley lies in: strips of one crop in blocks of different
/// orientation.
struct Parcel {
    Cover crop = Cover::kMeadow;
    double shade = 0;  ///< [-1, 1], one number for the whole parcel
    double row = 0;    ///< metres across the strip; crops stand in rows along it
};
[[nodiscard]] Parcel parcel_at(std::uint64_t seed, Vec2 p) noexcept;

/// Forest density of the land: above 0 it is forest.
[[nodiscard]] double woodiness(std::uint64_t seed, const CoverSite& site) noexcept;

}  // namespace terravox::survey
