#pragma once

#include <cstdint>

#include "voxelserver/make/voxelize/columns/window.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/voxelize/steps/ground_fill.hpp"

namespace terravox::voxelize {

/// The crown over a column.
struct Crown {
    static constexpr std::int32_t kNone = INT32_MIN;
    std::int32_t top = kNone;     ///< voxel of its highest return
    std::int32_t bottom = kNone;  ///< foliage reaches down to here
    ObjectVoxel top_voxel;        ///< class and colour of its top
    float height = kNoHeight;     ///< of its highest return, voxels
    bool trunk = false;           ///< the tree stands here
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
/// Ref: Popescu & Wynne, "Seeing the trees in the forest", 2004 (local maxima with a variable
/// window; crown width over height).
[[nodiscard]] Margined<Crown> fill_crowns(const Window& window, const ClassTable& classes,
                                          const GroundHeights& ground, const Settings& settings,
                                          double voxel_m);

}  // namespace terravox::voxelize
