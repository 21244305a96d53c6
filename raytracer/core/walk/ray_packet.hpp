#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "raytracer/core/base/ray_state.hpp"

namespace terravox::walk {

/// Up to 16 rays that go the same way on every axis, laid out for vector instructions. Each lane
/// holds a RayState, with the voxel as whole doubles. Rays with a component of zero, or with one
/// whose inverse is huge, are not accepted: see accepts().
struct alignas(64) RayPacket {
    static constexpr int kLanes = 16;
    RayPacket() noexcept {
        std::fill(std::begin(left_at), std::end(left_at), static_cast<std::int8_t>(-1));
    }

    // Limits for a lane: within them a crossing is off by so little that its voxel is found by one
    // step to either side.
    static constexpr double kMaxInverse = 1e9;
    static constexpr double kMaxOrigin = 1e8;
    /// Whether a ray may be a lane.
    [[nodiscard]] static bool accepts(const core::RayState& ray) noexcept {
        for (int a = 0; a < 3; ++a)
            if (!(std::abs(ray.inverse[a]) < kMaxInverse) ||
                !(std::abs(ray.origin[a]) < kMaxOrigin))
                return false;
        return true;
    }
    /// Whether a ray goes the way of the lanes that are there and is on their level.
    [[nodiscard]] bool fits(const core::RayState& ray) const noexcept {
        return count == 0 || (ray.level == level && ray.forward[0] == forward[0] &&
                              ray.forward[1] == forward[1] && ray.forward[2] == forward[2]);
    }
    /// Adds a ray that is placed in a voxel. Requires accepts() and fits().
    void add(const core::RayState& ray) noexcept {
        if (count == 0) {
            level = ray.level;
            for (int a = 0; a < 3; ++a)
                forward[a] = ray.forward[a];
        }
        for (int a = 0; a < 3; ++a) {
            origin[a][count] = ray.origin[a];
            direction[a][count] = ray.direction[a];
            inverse[a][count] = ray.inverse[a];
            voxel[a][count] = ray.voxel[a];
        }
        t[count] = ray.t;
        axis[count] = ray.face == core::Face::kNone ? -1 : core::to_axis(ray.face);
        ++count;
    }
    /// Switches the packet to a coarser level, as RayState::change_level does, for these lanes. The
    /// other lanes have finished.
    void coarsen(int to, std::uint32_t lanes) noexcept {
        for (int i = 0; i < kLanes; ++i)
            if ((lanes >> i & 1) == 0 && left_at[i] < 0)
                left_at[i] = static_cast<std::int8_t>(level);
        const double down = det::exp2_int(level - to);
        const double up = det::exp2_int(to - level);
        for (int a = 0; a < 3; ++a)
            for (int i = 0; i < kLanes; ++i) {
                if ((lanes >> i & 1) == 0)
                    continue;
                origin[a][i] *= down;
                direction[a][i] *= down;
                inverse[a][i] *= up;
                voxel[a][i] = std::floor(voxel[a][i] * down);
            }
        level = to;
    }
    /// Whether it is known that nothing lies ahead of lane i.
    [[nodiscard]] bool is_free(int i) const noexcept {
        if (free_axis < 0)
            return false;
        const double at = free_from[i] * det::exp2_int(-level);
        const double v = voxel[free_axis][i];
        return forward[free_axis] ? v >= at : v + 1 <= at;
    }
    /// Writes the position of lane i to a ray.
    /// @param ray the one that was added as this lane
    void update(int i, core::RayState& ray) const noexcept {
        ray.change_scale(left_at[i] < 0 ? level : left_at[i]);
        for (int a = 0; a < 3; ++a)
            ray.voxel[a] = static_cast<std::int32_t>(voxel[a][i]);
        ray.t = t[i];
        const int through = static_cast<int>(axis[i]);
        ray.face = through < 0 ? core::Face::kNone : core::to_face(through, !forward[through]);
    }

    // Lanes without a ray hold values that are never used.
    double origin[3][kLanes] = {}, direction[3][kLanes] = {}, inverse[3][kLanes] = {},
           voxel[3][kLanes] = {}, t[kLanes] = {}, axis[kLanes] = {};
    /// Plane on `free_axis`, in level-0 voxels, from which on nothing is in the lane's way.
    double free_from[kLanes] = {};
    /// Index in its box of the cell in which a lane was stopped; 0: hidden rock.
    std::uint64_t brick[kLanes] = {};
    bool forward[3] = {};
    int level = 0;
    int count = 0;
    int free_axis = -1;           ///< -1: no such planes are known
    std::int8_t left_at[kLanes];  ///< Level at which a lane finished; -1: that of the packet.
};

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
