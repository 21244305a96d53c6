#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

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

enum class TreeKind : std::uint8_t { kConifer, kBroadleaf, kBush };
[[nodiscard]] const char* to_name(TreeKind) noexcept;

/// A tree: a cone of needles or an ellipsoid of leaves.
struct Tree {
    Vec2 at;
    double ground_m = 0;      ///< height of the land at the trunk
    double height_m = 0;      ///< above the ground
    double radius_m = 0;      ///< of the crown, at its widest
    double crown_base_m = 0;  ///< above the ground
    TreeKind kind = TreeKind::kBroadleaf;
    std::uint32_t tint = 0;  ///< random, for the shade of the crown

    [[nodiscard]] double top_m() const noexcept { return ground_m + height_m; }
    /// @return height of the crown's upper side at a distance from the trunk, or nullopt beyond the
    /// crown
    [[nodiscard]] std::optional<double> crown_top_m(double distance_m) const noexcept;
    /// @return height of the crown's lower side at a distance within the crown
    [[nodiscard]] double crown_bottom_m(double distance_m) const noexcept;
};

/// Properties of the land that determine a tree.
struct TreeGround {
    Cover cover = Cover::kMeadow;
    double ground_m = 0;
    double to_obstacle_m = 1e9;  ///< to the edge of the nearest road, building or power line
    double above_valley_m = 0;
    double to_river_m = 1e9;  ///< from the bank
    bool wet = false;
    bool island = false;
};

/// The trees whose trunks stand in `area`: at most one in each cell of a lattice of kTreeCell_m, so
/// that any two areas agree.
/// @param land called once for each candidate
[[nodiscard]] std::vector<Tree> grow_trees(std::uint64_t seed, const Box2& area,
                                           const std::function<TreeGround(Vec2)>& land);

inline constexpr double kTreeCell_m = 5.0;
inline constexpr double kWidestCrown_m = 6.0;

}  // namespace terravox::survey
