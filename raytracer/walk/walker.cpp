#include "raytracer/walk/walker.hpp"

#include <algorithm>
#include <cmath>

namespace terravox {
namespace {

using voxel::child_bit;
using voxel::TreeCell;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::int32_t floor_to_int(double v) noexcept { return static_cast<std::int32_t>(std::floor(std::clamp(v, -2.0e9, 2.0e9))); }

}  // namespace

/// A ray on its way: the voxel it is in, and where it came from.
struct Walker::State {
    explicit State(const Ray& ray) noexcept {
        for (int a = 0; a < 3; ++a) {
            const double d = ray.direction[a];
            // A component of zero counts as positive with an infinite inverse: its next plane lies ahead, at t = infinity. From the
            // middle of its voxel, for on a plane that would be 0 * infinity.
            origin[a] = d == 0 ? std::floor(ray.origin[a]) + 0.5 : ray.origin[a];
            forward[a] = !(d < 0);
            inverse[a] = d == 0 ? kInfinity : 1 / d;
            direction[a] = d;
        }
    }

    /// t of the plane `coordinate = plane` on an axis.
    [[nodiscard]] double crossing(int axis, double plane) const noexcept { return (plane - origin[axis]) * inverse[axis]; }

    /// The first plane after the cell [low, low + size) on an axis, in the ray's direction.
    [[nodiscard]] double exit_plane(int axis, std::int32_t low, std::int32_t size) const noexcept {
        return forward[axis] ? static_cast<double>(low) + size : static_cast<double>(low);
    }

    /// The voxel the ray is in on `axis` once it has crossed, on `by_axis`, a plane at time `at`; known to lie in [low, high].
    /// A crossing (t, axis) comes before (at, by_axis) in the order of t, then axis.
    [[nodiscard]] std::int32_t position_after(int axis, double at, int by_axis, std::int32_t low, std::int32_t high) const noexcept {
        const auto crossed = [&](double plane) {
            const double c = crossing(axis, plane);
            return c < at || (c == at && axis < by_axis);
        };
        std::int32_t p = std::clamp(floor_to_int(origin[axis] + direction[axis] * at), low, high);
        if (forward[axis]) {
            while (p < high && crossed(static_cast<double>(p) + 1)) ++p;
            while (p > low && !crossed(p)) --p;
        } else {
            while (p > low && crossed(p)) --p;
            while (p < high && !crossed(static_cast<double>(p) + 1)) ++p;
        }
        return p;
    }

    /// Leaves the aligned empty cell of 2^sx x 2^sy x 2^sz voxels that the ray is in.
    void leap(int sx, int sy, int sz) noexcept {
        const int shift[3] = {sx, sy, sz};
        std::int32_t low[3], size[3];
        int axis = 0;
        double at = kInfinity;
        for (int a = 0; a < 3; ++a) {
            size[a] = std::int32_t{1} << shift[a];
            low[a] = voxel[a] & ~(size[a] - 1);
            const double c = crossing(a, exit_plane(a, low[a], size[a]));
            if (a == 0 || c < at) at = c, axis = a;
        }
        for (int a = 0; a < 3; ++a) {
            if (a == axis) continue;
            // A ray never turns back: what it has passed stays behind.
            const std::int32_t first = forward[a] ? voxel[a] : low[a], last = forward[a] ? low[a] + size[a] - 1 : voxel[a];
            if (size[a] > 1) voxel[a] = position_after(a, at, axis, first, last);
        }
        voxel[axis] = forward[axis] ? low[axis] + size[axis] : low[axis] - 1;
        t = at;
        face = face_of(axis, !forward[axis]);
    }

    double origin[3], direction[3], inverse[3];
    bool forward[3];
    std::int32_t voxel[3] = {};
    double t = 0;
    Face face = Face::kNone;
};

// Places the ray in its first voxel inside the bounds.
bool Walker::enter(State& s) const noexcept {
    int axis = -1;
    double at = 0;
    for (int a = 0; a < 3; ++a) {
        const auto i = static_cast<std::size_t>(a);
        if (m_bounds.min[i] >= m_bounds.max[i]) return false;
        const bool before = s.forward[a] ? s.origin[a] < m_bounds.min[i] : s.origin[a] >= m_bounds.max[i];
        const bool beyond = s.forward[a] ? s.origin[a] >= m_bounds.max[i] : s.origin[a] <= m_bounds.min[i];
        if (beyond) return false;
        if (!before) continue;
        const double c = s.crossing(a, s.forward[a] ? m_bounds.min[i] : m_bounds.max[i]);
        if (!(c < kInfinity)) return false;
        if (axis < 0 || c >= at) at = c, axis = a;  // the last to be crossed; of equals the later axis
    }
    for (int a = 0; a < 3; ++a) {
        const auto i = static_cast<std::size_t>(a);
        if (axis < 0) {
            s.voxel[a] = floor_to_int(s.origin[a]);
        } else if (a == axis) {
            s.voxel[a] = s.forward[a] ? m_bounds.min[i] : m_bounds.max[i] - 1;
        } else {
            constexpr std::int32_t kRoom = 1;  // a ray may pass the bounds before it crosses the axis: found below
            const std::int32_t low = m_bounds.min[i] - kRoom, own = floor_to_int(s.origin[a]);  // its own voxel's near plane is behind it
            s.voxel[a] = s.position_after(a, at, axis, s.forward[a] ? std::max(low, own) : low, m_bounds.max[i] - 1 + kRoom);
            if (s.voxel[a] < m_bounds.min[i] || s.voxel[a] >= m_bounds.max[i]) return false;
        }
    }
    s.t = at;
    if (axis >= 0) s.face = face_of(axis, !s.forward[axis]);
    return true;
}

std::optional<Hit> Walker::first_hit(const Ray& ray, StopAt stop, double t_max) {
    ++m_rays;
    State s(ray);
    if (!enter(s)) return std::nullopt;
    return walk(s, stop, t_max);
}

std::optional<Hit> Walker::first_hit_from(const Ray& ray, VoxelCoord start, StopAt stop, double t_max) {
    ++m_rays;
    State s(ray);
    for (int a = 0; a < 3; ++a) {
        s.voxel[a] = start[a];
        if (s.direction[a] == 0) s.origin[a] = start[a] + 0.5;
    }
    return walk(s, stop, t_max);
}

std::optional<Hit> Walker::walk(State& s, StopAt stop, double t_max) {
    const auto inside = [&] {
        for (int a = 0; a < 3; ++a) {
            const auto i = static_cast<std::size_t>(a);
            if (s.forward[a] ? s.voxel[a] >= m_bounds.max[i] : s.voxel[a] < m_bounds.min[i]) return false;
        }
        return true;
    };
    const auto hit = [&](const voxel::VoxelAttr& attr, bool hole) { return Hit{s.t, {s.voxel[0], s.voxel[1], s.voxel[2]}, s.face, attr, hole}; };
    while (inside() && s.t <= t_max) {
        ++m_steps;
        const std::int32_t x = s.voxel[0], y = s.voxel[1], z = s.voxel[2];
        const BlockRef& ref = m_reader.get(x >> 6, y >> 8, z >> 6);
        if (ref.hole) return hit({}, true);
        if (!ref.box) {
            s.leap(6, 8, 6);
            continue;
        }
        const std::span<const TreeCell> cells = ref.box->cells();
        const TreeCell* cell = &cells[static_cast<std::size_t>(y >> 6 & 3)];
        if (cell->mask == 0) {
            s.leap(6, 6, 6);
            continue;
        }
        int shift = 4;
        bool empty = false, hidden = false;
        for (; shift > 0; shift -= 2) {
            const int bit = child_bit(x >> shift, y >> shift, z >> shift);
            if ((cell->mask >> bit & 1) == 0) { empty = true; break; }
            if ((cell->detail >> bit & 1) == 0) { hidden = true; break; }
            cell = &cells[cell->index_of(bit)];
        }
        if (hidden) return hit({}, false);
        if (empty) {
            s.leap(shift, shift, shift);
            continue;
        }
        // In a brick: single steps until it is left or something stops the ray.
        while (true) {
            const int bit = child_bit(s.voxel[0], s.voxel[1], s.voxel[2]);
            if ((cell->mask >> bit & 1) != 0) {
                const voxel::VoxelAttr attr = (cell->detail >> bit & 1) != 0 ? ref.box->attrs()[cell->index_of(bit)] : voxel::VoxelAttr{};
                if (stop == StopAt::kSolid || attr.material != voxel::Material::kWater) {
                    if (s.t > t_max) return std::nullopt;
                    return hit(attr, false);
                }
            }
            ++m_steps;
            s.leap(0, 0, 0);
            if ((s.voxel[0] ^ x) >> 2 != 0 || (s.voxel[1] ^ y) >> 2 != 0 || (s.voxel[2] ^ z) >> 2 != 0) break;
        }
    }
    return std::nullopt;
}

}  // namespace terravox
