#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "common/util/det_math.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/core/base/ray.hpp"

namespace terravox::core {

/// Integer coordinates of a voxel of some level.
struct VoxelCoord {
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t z = 0;
    [[nodiscard]] std::int32_t operator[](int axis) const noexcept {
        return axis == 0 ? x : axis == 1 ? y : z;
    }
    friend bool operator==(const VoxelCoord&, const VoxelCoord&) = default;
};

inline constexpr double kFar = std::numeric_limits<double>::infinity();

/// A ray on its way: the voxel that it is in and where it came from. A plain value, so that a ray
/// may be deferred and resumed.
///
/// Every crossing is (plane - origin) / direction, never a sum, and ties go to x before y before z:
/// a leap over a large cell therefore ends in exactly the voxel that single steps would have
/// reached. `origin`, `direction` and `voxel` are in voxels of `level`; changing the level
/// multiplies by powers of two, so that t does not change even in the last bit. See docs/adr/0005
/// and 0015. Ref: Amanatides & Woo, "A Fast Voxel Traversal Algorithm", Eurographics 1987.
struct RayState {
    RayState() = default;
    /// At level 0 and not placed in a voxel yet: call enter() or start_in() next.
    explicit RayState(const Ray& ray) noexcept {
        for (int a = 0; a < 3; ++a) {
            const double d = ray.direction[a];
            // A component of zero counts as positive with an infinite inverse: its next plane lies
            // ahead, at t = infinity. Its origin moves to the middle of its voxel, because on a
            // plane the crossing would be 0 * infinity.
            origin[a] = d == 0 ? std::floor(ray.origin[a]) + 0.5 : ray.origin[a];
            forward[a] = !(d < 0);
            inverse[a] = d == 0 ? kFar : 1 / d;
            direction[a] = d;
        }
    }

    /// Places the ray, which must be at level 0, in its first voxel inside the bounds.
    /// @return false when it never reaches the bounds
    [[nodiscard]] bool enter(const voxel::VoxelBounds& bounds) noexcept {
        int axis = -1;
        double at = 0;
        for (int a = 0; a < 3; ++a) {
            const auto i = static_cast<std::size_t>(a);
            if (bounds.min[i] >= bounds.max[i])
                return false;
            const bool before = forward[a] ? origin[a] < bounds.min[i] : origin[a] >= bounds.max[i];
            const bool beyond =
                forward[a] ? origin[a] >= bounds.max[i] : origin[a] <= bounds.min[i];
            if (beyond)
                return false;
            if (!before)
                continue;
            const double c = crossing(a, forward[a] ? bounds.min[i] : bounds.max[i]);
            if (!(c < kFar))
                return false;
            if (axis < 0 || c >= at) {
                at = c;
                axis = a;
            }  // the last axis to be crossed; of equal crossings the later axis
        }
        for (int a = 0; a < 3; ++a) {
            const auto i = static_cast<std::size_t>(a);
            if (axis < 0) {
                voxel[a] = floor_to_int(origin[a]);
            } else if (a == axis) {
                voxel[a] = forward[a] ? bounds.min[i] : bounds.max[i] - 1;
            } else {
                // A ray may cross this axis outside the bounds, before it enters through `axis`:
                // checked below.
                constexpr std::int32_t kRoom = 1;
                // The near plane of the ray's own voxel is behind it.
                const std::int32_t low = bounds.min[i] - kRoom;
                const std::int32_t own = floor_to_int(origin[a]);
                voxel[a] = position_after(a, at, axis, forward[a] ? std::max(low, own) : low,
                                          bounds.max[i] - 1 + kRoom);
                if (voxel[a] < bounds.min[i] || voxel[a] >= bounds.max[i])
                    return false;
            }
        }
        t = at;
        if (axis >= 0)
            face = to_face(axis, !forward[axis]);
        return true;
    }

    /// Places a ray that starts on a face: in voxel `start` of `its_level`, whatever rounding makes
    /// of its origin.
    void start_in(VoxelCoord start, int its_level) noexcept {
        rescale(its_level);
        // A component of zero keeps the middle of a level-0 voxel, so that it lies on no plane of
        // any level.
        const double half = 0.5 * det::exp2_int(-its_level);
        for (int a = 0; a < 3; ++a) {
            voxel[a] = start[a];
            if (direction[a] == 0)
                origin[a] = std::clamp(origin[a], start[a] + half, start[a] + 1 - half);
        }
    }

    /// The same for a ray of this direction from another origin: for many rays this spares the
    /// divisions.
    /// @param from level-0 voxels
    /// @param start of the ray's level
    void restart_in(VoxelCoord start, const Vec3& from) noexcept {
        const double down = det::exp2_int(-level);
        for (int a = 0; a < 3; ++a) {
            voxel[a] = start[a];
            origin[a] = from[a] * down;
            if (direction[a] == 0)
                origin[a] = std::clamp((std::floor(from[a]) + 0.5) * down, start[a] + 0.5 * down,
                                       start[a] + 1 - 0.5 * down);
        }
    }

    /// Switches to the scale of another level, except for `voxel`, which the caller sets next.
    void change_scale(int to) noexcept {
        if (to != level)
            rescale(to);
    }

    /// Switches to the scale of another level; `voxel` becomes the voxel of that level that
    /// contains the ray.
    void change_level(int to) noexcept {
        if (to == level)
            return;
        const int finer = level - to;
        rescale(to);
        for (int a = 0; a < 3; ++a) {
            if (finer < 0) {
                voxel[a] >>= -finer;
                continue;
            }
            const std::int32_t low = voxel[a] << finer;
            const std::int32_t high = low + (std::int32_t{1} << finer) - 1;
            if (face == Face::kNone)
                voxel[a] = std::clamp(floor_to_int(origin[a] + direction[a] * t), low, high);
            else if (a == to_axis(face))
                voxel[a] = forward[a] ? low : high;  // the ray has just come through this face
            else
                voxel[a] = position_after(a, t, to_axis(face), low, high);
        }
    }

    /// t of the plane `coordinate = plane` on an axis.
    [[nodiscard]] double crossing(int axis, double plane) const noexcept {
        return (plane - origin[axis]) * inverse[axis];
    }

    /// The voxel coordinate of the ray on `axis` once it has crossed, on `by_axis`, a plane at time
    /// `at`. The result is known to lie in [low, high]. A crossing (t, axis) comes before (at,
    /// by_axis) in the order of t, then axis.
    [[nodiscard]] std::int32_t position_after(int axis, double at, int by_axis, std::int32_t low,
                                              std::int32_t high) const noexcept {
        const auto crossed = [&](double plane) {
            const double c = crossing(axis, plane);
            return c < at || (c == at && axis < by_axis);
        };
        std::int32_t p = std::clamp(floor_to_int(origin[axis] + direction[axis] * at), low, high);
        if (forward[axis]) {
            while (p < high && crossed(static_cast<double>(p) + 1))
                ++p;
            while (p > low && !crossed(p))
                --p;
        } else {
            while (p > low && crossed(p))
                --p;
            while (p < high && !crossed(static_cast<double>(p) + 1))
                ++p;
        }
        return p;
    }

    /// Leaves, in one step, the aligned empty cell of 2^shift voxels on each axis that contains the
    /// ray.
    void leap(int shift) noexcept { leap(shift, shift, shift); }
    void leap(int sx, int sy, int sz) noexcept {
        const int shift[3] = {sx, sy, sz};
        std::int32_t low[3], high[3];
        double out[3];
        for (int a = 0; a < 3; ++a) {
            low[a] = voxel[a] >> shift[a] << shift[a];
            high[a] = low[a] + (std::int32_t{1} << shift[a]) - 1;
            out[a] = crossing(
                a, forward[a] ? static_cast<double>(high[a]) + 1 : static_cast<double>(low[a]));
        }
        const int axis = find_first(out);
        const double at = out[axis];
        for (int a = 0; a < 3; ++a) {
            if (a == axis || shift[a] == 0)
                continue;
            // A ray never turns back: the voxels that it has passed are excluded.
            voxel[a] = position_after(a, at, axis, forward[a] ? voxel[a] : low[a],
                                      forward[a] ? high[a] : voxel[a]);
        }
        voxel[axis] = forward[axis] ? high[axis] + 1 : low[axis] - 1;
        t = at;
        face = to_face(axis, !forward[axis]);
    }

    /// The axis of the earliest of three crossings; the first axis of equal ones.
    [[nodiscard]] static int find_first(const double (&at)[3]) noexcept {
        return at[0] <= at[1] ? (at[0] <= at[2] ? 0 : 2) : (at[1] <= at[2] ? 1 : 2);
    }

    [[nodiscard]] static std::int32_t floor_to_int(double v) noexcept {
        return static_cast<std::int32_t>(std::floor(std::clamp(v, -2.0e9, 2.0e9)));
    }

    double origin[3] = {}, direction[3] = {}, inverse[3] = {};
    double t = 0;  ///< multiples of the ray's direction
    std::int32_t voxel[3] = {};
    bool forward[3] = {};
    Face face = Face::kNone;  ///< face through which it entered its voxel; kNone: it started there
    std::int8_t level = 0;

private:
    void rescale(int to) noexcept {
        const double up = det::exp2_int(to - level);
        const double down = det::exp2_int(level - to);
        for (int a = 0; a < 3; ++a) {
            origin[a] *= down;
            direction[a] *= down;
            inverse[a] *= up;
        }
        level = static_cast<std::int8_t>(to);
    }
};

}  // namespace terravox::core
