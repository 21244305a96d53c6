#include "voxelserver/tools/survey/vegetation.hpp"

#include <array>

#include "voxelserver/tools/survey/hash.hpp"
#include "voxelserver/tools/survey/noise.hpp"

namespace terravox::survey {
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

TreeKind kind_of(std::uint64_t seed, Vec2 p, const TreeGround& land, Random& random) noexcept {
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

const char* name_of(TreeKind kind) noexcept {
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
            Random random(hash_of(seed, 0x7EE, i, j));
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
            tree.kind = kind_of(seed, p, here, random);
            tree = shaped(tree, here, random);
            if (here.to_obstacle_m > std::max(1.2, 0.6 * tree.radius_m))
                trees.push_back(tree);
        }
    return trees;
}

}  // namespace terravox::survey
