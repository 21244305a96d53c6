#pragma once

#include <cstdint>

namespace terravox::walk {

/// Rays in lanes for vector instructions, each in a box of its own. Axes on which a ray goes down
/// are mirrored, v -> -1 - v, so that all go up. Voxels are whole numbers, stored as the bits of
/// kWholeNumber + v.
struct alignas(64) RayLanes {
    static constexpr int kLanes = 16;
    static constexpr int kRoots = 4;
    /// Adding a whole number of magnitude below 2^51 to this leaves it in the low bits of the sum.
    static constexpr double kWholeNumber = 6755399441055744.0;
    /// Far greater than the rounding error of a position, and far smaller than a voxel.
    static constexpr double kSlack_voxel = 1.0 / (1 << 16);

    // Set when a lane is loaded.
    double origin[3][kLanes] = {}, direction[3][kLanes] = {}, inverse[3][kLanes] = {};
    double end[3][kLanes] = {};  ///< first voxels that are no longer the lane's, kWholeNumber + v
    /// `origin`, reduced so that rounding a position to the nearest whole number gives its voxel or
    /// the one before.
    double estimate[3][kLanes] = {};
    std::uint64_t cells[kLanes] = {};  ///< address of the box's first cell, in words of 8 bytes
    /// Mask, detail and first child of the box's roots, in the order in which the ray meets them.
    std::uint64_t root[3][kRoots][kLanes] = {};
    std::uint64_t flip[kLanes] = {};  ///< of the bits of a child, where axes are mirrored
    // Where the ray is.
    double voxel[3][kLanes] = {};  ///< kWholeNumber + v
    double axis[kLanes] = {};      ///< axis crossed last; -1: none in this box
    // What is there; used by the steps only.
    std::uint64_t node[kLanes] = {}, node_detail[kLanes] = {}, node_first[kLanes] = {},
                  node_size[kLanes] = {}, brick[kLanes] = {}, solid[kLanes] = {}, size[kLanes] = {};
    // Bit masks of lanes.
    std::uint32_t going = 0;  ///< still moving in their boxes
    std::uint32_t fresh = 0;  ///< those of `going` loaded since the last steps
    /// In a solid voxel: `brick` is the index of its cell in the box, or 0 for hidden rock.
    std::uint32_t stopped = 0;
};

}  // namespace terravox::walk
