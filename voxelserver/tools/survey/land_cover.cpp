#include "voxelserver/tools/survey/land_cover.hpp"

#include <array>

#include "voxelserver/tools/survey/randomness.hpp"

namespace terravox::survey {
namespace {

constexpr double kBlock_m = 190;       ///< parcels in one block have one direction
constexpr double kGardenReach_m = 38;  ///< from a street with houses
constexpr double kRockSlope = 1.2;
constexpr double kFieldSlope = 0.16;
constexpr double kLakeMeadow_m = 20;
constexpr double kHighestField_m = 30;

Cover choose_crop(double dice) noexcept {
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
    const std::uint64_t block = compute_hash(seed, 0xF1E1D, bx, by);
    const bool eastward = (block & 1U) != 0;
    const double across = eastward ? warped.y - static_cast<double>(by) * kBlock_m
                                   : warped.x - static_cast<double>(bx) * kBlock_m;
    const double width = kBlock_m / static_cast<double>(7 + (block >> 8) % 7);
    const auto strip = static_cast<std::int64_t>(std::floor(across / width));
    Random random(compute_hash(block, strip));
    return {choose_crop(random.unit()), random.range(-1.0, 1.0), across};
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

namespace {

// How likely a tree stands in a cell.
double likelihood(std::uint64_t seed, Vec2 p, const TreeGround& land) noexcept {
    const bool gallery = land.to_river_m < 9.0 && land.to_river_m > 1.0;
    switch (land.cover) {
        case Cover::kForest: return 0.93;
        case Cover::kScrub: return 0.22;
        case Cover::kRock: return 0.10;
        case Cover::kGarden: return land.island ? 0.55 : gallery ? 0.5 : 0.19;
        case Cover::kMeadow:
        case Cover::kMownMeadow: {
            // Hedges and single trees; orchards where the noise is high.
            const double orchard = noise_2d(seed + 3, p.x / 90.0, p.y / 90.0);
            return gallery ? 0.55 : orchard > 0.55 ? 0.45 : 0.008;
        }
        case Cover::kWheat:
        case Cover::kBarley:
        case Cover::kMaize:
        case Cover::kRape:
        case Cover::kPloughed: return gallery ? 0.5 : 0.0;
        default: return 0.0;
    }
}

TreeKind find_kind(std::uint64_t seed, Vec2 p, const TreeGround& land, Random& random) noexcept {
    if (land.cover == Cover::kScrub)
        return random.chance(0.55) ? TreeKind::kBush : TreeKind::kBroadleaf;
    if (land.cover == Cover::kRock)
        return random.chance(0.6) ? TreeKind::kBush : TreeKind::kConifer;
    if (land.cover != Cover::kForest)
        return random.chance(land.cover == Cover::kGarden ? 0.16 : 0.08) ? TreeKind::kConifer
               : random.chance(0.25)                                     ? TreeKind::kBush
                                                                         : TreeKind::kBroadleaf;
    const double stand = noise_2d(seed + 4, p.x / 130.0, p.y / 130.0) + land.above_valley_m / 260.0;
    return random.chance(std::clamp(0.42 + 0.6 * stand, 0.04, 0.96)) ? TreeKind::kConifer
                                                                     : TreeKind::kBroadleaf;
}

Tree shaped(Tree tree, const TreeGround& land, Random& random) noexcept {
    const bool forest = land.cover == Cover::kForest;
    switch (tree.kind) {
        case TreeKind::kConifer:
            tree.height_m = forest ? random.range(17, 32) : random.range(8, 20);
            tree.radius_m = 1.3 + 0.085 * tree.height_m;
            tree.crown_base_m = tree.height_m * (forest ? 0.2 : 0.08);
            break;
        case TreeKind::kBroadleaf:
            tree.height_m = forest ? random.range(14, 25) : random.range(5, 14);
            tree.radius_m = std::min(
                kWidestCrown_m, (forest ? 0.18 : 0.30) * tree.height_m * random.range(0.85, 1.2));
            tree.crown_base_m = tree.height_m * (forest ? 0.38 : 0.24);
            break;
        case TreeKind::kBush:
            tree.height_m = random.range(1.2, 3.6);
            tree.radius_m = random.range(0.9, 1.9);
            tree.crown_base_m = 0.15;
            break;
    }
    return tree;
}

}  // namespace

const char* to_name(TreeKind kind) noexcept {
    constexpr std::array kNames = {"conifer", "broadleaf", "bush"};
    return kNames[static_cast<std::size_t>(kind)];
}

std::optional<double> Tree::crown_top_m(double distance_m) const noexcept {
    const double part = distance_m / radius_m;
    if (part > 1.0)
        return std::nullopt;
    if (kind == TreeKind::kConifer)
        return ground_m + lerp(height_m, crown_base_m, part);
    const double middle = 0.5 * (height_m + crown_base_m);
    return ground_m + middle + (height_m - middle) * std::sqrt(1.0 - part * part);
}

double Tree::crown_bottom_m(double distance_m) const noexcept {
    if (kind == TreeKind::kConifer)
        return ground_m + crown_base_m;
    const double part = std::min(1.0, distance_m / radius_m);
    const double middle = 0.5 * (height_m + crown_base_m);
    return ground_m + middle - (height_m - middle) * std::sqrt(1.0 - part * part);
}

std::vector<Tree> grow_trees(std::uint64_t seed, const Box2& area,
                             const std::function<TreeGround(Vec2)>& land) {
    std::vector<Tree> trees;
    const auto cell = [](double v) {
        return static_cast<std::int64_t>(std::floor(v / kTreeCell_m));
    };
    for (auto j = cell(area.y0); j <= cell(area.y1); ++j)
        for (auto i = cell(area.x0); i <= cell(area.x1); ++i) {
            Random random(compute_hash(seed, 0x7EE, i, j));
            const Vec2 p{(static_cast<double>(i) + random.range(0.08, 0.92)) * kTreeCell_m,
                         (static_cast<double>(j) + random.range(0.08, 0.92)) * kTreeCell_m};
            if (!area.contains(p))
                continue;
            const TreeGround here = land(p);
            if (here.wet || !random.chance(likelihood(seed, p, here)))
                continue;
            Tree tree;
            tree.at = p;
            tree.ground_m = here.ground_m;
            tree.tint = static_cast<std::uint32_t>(random.next());
            tree.kind = find_kind(seed, p, here, random);
            tree = shaped(tree, here, random);
            if (here.to_obstacle_m > std::max(1.2, 0.6 * tree.radius_m))
                trees.push_back(tree);
        }
    return trees;
}

}  // namespace terravox::survey
