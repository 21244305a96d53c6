#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "voxelserver/make/voxelize/columns/columns.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/voxelize/steps/ground_fill.hpp"

namespace terravox::voxelize {

/// Step "isolated points": whether an object's voxel is isolated: no other return within two voxels
/// horizontally and three vertically.
/// @param x, z in [-62, 126)
[[nodiscard]] bool isolated(const Window& window, int x, int z, std::int32_t y);

/// Which tree the foliage over a column belongs to: that of the local maximum of the canopy that
/// lies uphill. Climbs by the highest column around, at most kJumps times, and so sees a few
/// columns beyond the patch, the same from every patch.
class TreePlaces {
public:
    TreePlaces(const Window& window, const ClassTable& classes, double voxel_m);

    /// @param x, z in [-2, 66)
    /// @return the absolute voxels (x, z) of the tree's highest column
    [[nodiscard]] std::array<std::int32_t, 2> at(int x, int z);

private:
    static constexpr int kJumps = 6;
    static constexpr int kMaxRadius = 4;
    static constexpr int kMargin = 2 + kMaxRadius * (kJumps + 1);
    static_assert(kMargin < Window::kMargin);
    static constexpr int kSide = grid::kPatchSize + 2 * kMargin;
    static constexpr std::size_t kCount = std::size_t{kSide} * kSide;

    struct Place {
        std::int16_t x = 0;
        std::int16_t z = 0;
    };
    /// @param x, z in [-kMargin, 64 + kMargin)
    [[nodiscard]] static constexpr std::size_t index(int x, int z) noexcept {
        return static_cast<std::size_t>((z + kMargin) * kSide + x + kMargin);
    }
    [[nodiscard]] std::int64_t top(const ObjectVoxel& highest) const noexcept;
    [[nodiscard]] Place uphill(Place from) const noexcept;

    const Window& m_window;
    const ClassTable& m_classes;
    int m_radius;
    // Of the patch's columns and a margin of kMargin around them, by index().
    std::vector<std::int64_t> m_tops;  ///< top()
    std::vector<Place> m_next;         ///< the next place uphill, once it is known
    std::vector<char> m_known;
};

/// The crown over a column.
struct Crown {
    static constexpr std::int32_t kNone = INT32_MIN;
    std::int32_t top = kNone;     ///< voxel of its highest return
    std::int32_t bottom = kNone;  ///< foliage reaches down to here
    ObjectVoxel top_voxel;        ///< class and colour of its top
    float height = kNoHeight;     ///< of its highest return, voxels
    bool trunk = false;           ///< the tree stands here
    bool passed = false;          ///< a pulse of this column went deeper
    [[nodiscard]] bool seen() const noexcept { return top != kNone; }
};

/// Step "vegetation": crowns of plants higher than a shrub.
///
/// Few pulses are returned by the inside of a crown: a column without returns among crown columns
/// takes the median of theirs, and foliage reaches down to the level of lower neighbouring crown
/// tops (as long as they may be of one crown, which is seldom longer than half its tree), so that a
/// crown is one body. A trunk stands under each local maximum of the canopy, in a window that
/// widens with the height. A plateau (touching columns of exactly equal height above the ground) is
/// one maximum, or none where something higher touches it; its trunk stands inside. No step sees
/// farther than its margin, so that a plateau of more than six columns from its middle may get a
/// second trunk.
///
/// Returns of houses (HouseReturns) are no crowns, and no foliage is guessed beside a wall as high.
/// Unclassified returns are of many kinds and often few: where they are trees, a pit deep inside a
/// crown is closed, foliage reaches down to half the height of the tree, and trunks stand farther
/// apart. No tree is what is level there and lets hardly any pulse through, such as a deck, and
/// what is slender, such as a mast or a wire: it has no trunk, and is only where it was measured.
/// Ref: Popescu & Wynne, "Seeing the trees in the forest", 2004 (local maxima with a variable
/// window; crown width over height).
[[nodiscard]] Margined<Crown> fill_crowns(const Window& window, const ClassTable& classes,
                                          const GroundHeights& ground, const Settings& settings,
                                          double voxel_m);

}  // namespace terravox::voxelize
