#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "voxelserver/tools/survey/land_cover.hpp"
#include "voxelserver/tools/survey/plane.hpp"

namespace terravox::survey {

enum class TreeKind : std::uint8_t { kConifer, kBroadleaf, kBush };
[[nodiscard]] const char* name_of(TreeKind) noexcept;

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
inline constexpr double kTallestTree_m = 34.0;
inline constexpr double kWidestCrown_m = 6.0;

}  // namespace terravox::survey
