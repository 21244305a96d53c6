#pragma once

#include <cstdint>

namespace terravox::walk {

/// Rays side by side for vector instructions, each in a box of its own. Axes that a ray goes down
/// are mirrored, v -> -1 - v, so that all go up. Voxels are whole numbers as the bits of
/// kWholeNumber + v.
struct alignas(64) RayLanes {
    static constexpr int kLanes = 16, kRoots = 4;
    /// A whole number below 2^51 either way, added to this, stands in the low bits of the sum.
    static constexpr double kWholeNumber = 6755399441055744.0;
    /// Far above what rounding does to a position, far below a voxel.
    static constexpr double kSlack_voxel = 1.0 / (1 << 16);

    // Set when a lane is loaded.
    double origin[3][kLanes] = {}, direction[3][kLanes] = {}, inverse[3][kLanes] = {};
    double end[3][kLanes] = {};  ///< first voxels that are no longer the lane's, kWholeNumber + v
    double estimate[3][kLanes] = {};  ///< `origin`, less so much that the nearest whole number of a
                                      ///< position is its voxel or the one before
    std::uint64_t cells[kLanes] = {};  ///< address of the box's first cell, in words of 8 bytes
    std::uint64_t root[3][kRoots][kLanes] =
        {};  ///< mask, detail, first child of its roots, in the order that the ray meets them
    std::uint64_t flip[kLanes] = {};  ///< of the bit of a child, where axes are mirrored
    // Where it is.
    double voxel[3][kLanes] = {};  ///< kWholeNumber + v
    double axis[kLanes] = {};      ///< crossed last; -1: none in this box
    // What is there, and nobody's business but that of the steps.
    std::uint64_t node[kLanes] = {}, node_detail[kLanes] = {}, node_first[kLanes] = {},
                  node_size[kLanes] = {}, brick[kLanes] = {}, solid[kLanes] = {}, size[kLanes] = {};
    // Lanes as bits.
    std::uint32_t going = 0;  ///< on their way in their boxes
    std::uint32_t fresh = 0;  ///< of those: loaded since the last steps
    std::uint32_t stopped =
        0;  ///< in a solid voxel: `brick` is its cell's index in the box, or 0 for hidden rock
};

}  // namespace terravox::walk
