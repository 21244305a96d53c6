#pragma once

#include <cmath>
#include <optional>

#include "raytracer/core/walk/walk.hpp"
#include "tests/common/voxel/array_world.hpp"

namespace terravox::test {

/// Single steps through a plain array: what Walker must agree with, voxel, face and t, to the last
/// bit. A plane is crossed at (plane - origin) * (1 / direction); of planes crossed at one time x
/// comes before y before z.
/// @param start the voxel the ray starts in; without it the one that holds the origin
inline std::optional<walk::Hit> reference_hit(const ArrayWorld& world, const core::Ray& ray,
                                              const std::optional<core::VoxelCoord>& start,
                                              walk::StopAt stop, double t_max) {
    const voxel::VoxelBounds& b = world.level_bounds();
    if (b.empty())
        return std::nullopt;
    std::int32_t v[3];
    double inverse[3];
    for (int a = 0; a < 3; ++a) {
        v[a] = start ? (*start)[a] : static_cast<std::int32_t>(std::floor(ray.origin[a]));
        inverse[a] = ray.direction[a] == 0 ? 0 : 1 / ray.direction[a];
    }
    // On the plane where the world ends, on its way out: it has left already.
    for (int a = 0; a < 3; ++a)
        if (!start && ray.direction[a] < 0 && ray.origin[a] == b.min[static_cast<std::size_t>(a)])
            return std::nullopt;
    const auto level = static_cast<std::int8_t>(world.level());
    double t = 0;
    core::Face face = core::Face::kNone;
    bool been_inside = false;
    while (t <= t_max) {
        bool inside = true;
        bool outside = false;
        for (int a = 0; a < 3; ++a) {
            const auto i = static_cast<std::size_t>(a);
            const bool before = v[a] < b.min[i];
            const bool beyond = v[a] >= b.max[i];
            const double d = ray.direction[a];
            outside = outside || (beyond && d >= 0) || (before && d <= 0);
            inside = inside && !before && !beyond;
        }
        if (outside && !(stop.air_stops && been_inside))
            return std::nullopt;
        been_inside = been_inside || inside;
        // A medium ends where the world does.
        if (outside)
            return walk::Hit{
                t, {v[0], v[1], v[2]}, face, level, false, {voxel::Material::kAir, 0, 0, 0, {}, 0}};
        if (inside) {
            if (world.is_hole(v[0], v[1], v[2]))
                return walk::Hit{t, {v[0], v[1], v[2]}, face, level, true, {}};
            const auto m = world.at(v[0], v[1], v[2]);
            if ((stop.air_stops || m != voxel::Material::kAir) && m != stop.passed) {
                voxel::VoxelAttr attr;
                if (!world.hidden(v[0], v[1], v[2]))
                    attr.material = m;
                return walk::Hit{t, {v[0], v[1], v[2]}, face, level, false, attr};
            }
        }
        int axis = -1;
        double next = 0;
        for (int a = 0; a < 3; ++a) {
            if (ray.direction[a] == 0)
                continue;
            const double plane = ray.direction[a] > 0 ? v[a] + 1.0 : v[a];
            const double c = (plane - ray.origin[a]) * inverse[a];
            if (axis < 0 || c < next) {
                next = c;
                axis = a;
            }
        }
        if (axis < 0)
            return std::nullopt;
        v[axis] += ray.direction[axis] > 0 ? 1 : -1;
        t = next;
        face = core::to_face(axis, ray.direction[axis] < 0);
    }
    return std::nullopt;
}

}  // namespace terravox::test
