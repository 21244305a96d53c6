#include "voxelserver/tools/survey/land_cover.hpp"

#include "voxelserver/tools/survey/hash.hpp"
#include "voxelserver/tools/survey/noise.hpp"

namespace terravox::survey {
namespace {

constexpr double kBlock_m = 190;       ///< parcels in one block have one direction
constexpr double kGardenReach_m = 38;  ///< from a street with houses
constexpr double kRockSlope = 1.2;
constexpr double kFieldSlope = 0.16;
constexpr double kLakeMeadow_m = 20;
constexpr double kHighestField_m = 30;

Cover crop_of(double dice) noexcept {
    if (dice < 0.34)
        return Cover::kMeadow;
    if (dice < 0.56)
        return Cover::kMownMeadow;
    if (dice < 0.68)
        return Cover::kWheat;
    if (dice < 0.77)
        return Cover::kBarley;
    if (dice < 0.88)
        return Cover::kMaize;
    if (dice < 0.905)
        return Cover::kRape;
    return Cover::kPloughed;
}

}  // namespace

Parcel parcel_at(std::uint64_t seed, Vec2 p) noexcept {
    // Warped, so that no boundary is a straight line; turned by 3 in 20, so that none follows the
    // squares.
    const Vec2 warped{p.x + 0.15 * p.y + 9.0 * noise_2d(seed + 11, p.x / 120.0, p.y / 120.0),
                      p.y - 0.15 * p.x + 9.0 * noise_2d(seed + 12, p.x / 120.0, p.y / 120.0)};
    const auto bx = static_cast<std::int64_t>(std::floor(warped.x / kBlock_m));
    const auto by = static_cast<std::int64_t>(std::floor(warped.y / kBlock_m));
    const std::uint64_t block = hash_of(seed, 0xF1E1D, bx, by);
    const bool eastward = (block & 1U) != 0;
    const double across = eastward ? warped.y - static_cast<double>(by) * kBlock_m
                                   : warped.x - static_cast<double>(bx) * kBlock_m;
    const double width = kBlock_m / static_cast<double>(7 + (block >> 8) % 7);
    const auto strip = static_cast<std::int64_t>(std::floor(across / width));
    Random random(hash_of(block, strip));
    return {crop_of(random.unit()), random.range(-1.0, 1.0), across};
}

double woodiness(std::uint64_t seed, const CoverSite& site) noexcept {
    const double groves = fractal_2d(seed + 21, site.at.x / 300.0, site.at.y / 300.0, 3);
    const double height = std::min(site.above_valley_m / 60.0, 1.3);
    return 1.15 * groves + 0.50 * height + 0.75 * std::min(site.slope, 0.8) - 0.60 -
           1.6 * (1.0 - smoothstep(15.0, 75.0, site.to_street_m));
}

Cover natural_cover(std::uint64_t seed, const CoverSite& site) noexcept {
    const double ragged = 0.16 * noise_2d(seed + 31, site.at.x / 7.0, site.at.y / 7.0);
    if (site.slope + ragged > kRockSlope)
        return Cover::kRock;
    if (site.to_water_m < 1.6 + 6.0 * ragged && !site.island)
        return Cover::kBeach;
    if (site.island)
        return Cover::kGarden;
    if (woodiness(seed, site) > 0.0)
        return Cover::kForest;
    if (site.to_street_m < kGardenReach_m + 40.0 * ragged)
        return Cover::kGarden;
    if (site.slope > kFieldSlope)
        return woodiness(seed + 41, site) > -0.2 ? Cover::kScrub : Cover::kMeadow;
    // Grass only along lakes and high up.
    if (site.to_water_m < kLakeMeadow_m || site.above_valley_m > kHighestField_m)
        return Cover::kMeadow;
    return parcel_at(seed, site.at).crop;
}

}  // namespace terravox::survey
