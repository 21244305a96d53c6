#include "raytracer/core/walk/beam.hpp"

#include <algorithm>
#include <cmath>

namespace terravox::walk {
namespace {

constexpr double kMaxSlope = 8;   // a beam that leans more is not marched
constexpr int kMaxFineSlabs = 6;  // of the finest thickness: then single rays are cheaper
constexpr std::int32_t kFirstSlab = 4;

int major_axis(core::Vec3 d) noexcept {
    const double x = std::abs(d.x);
    const double y = std::abs(d.y);
    const double z = std::abs(d.z);
    return x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
}

}  // namespace

bool Beam::make(core::Vec3 eye, const core::Vec3 (&corners)[4], Beam& beam) noexcept {
    const core::Vec3 middle = corners[0] + corners[1] + corners[2] + corners[3];
    beam.axis = major_axis(middle);
    beam.forward = middle[beam.axis] > 0;
    for (int a = 0; a < 3; ++a) {
        beam.eye[a] = eye[a];
        beam.slope_min[a] = core::kFar;
        beam.slope_max[a] = -core::kFar;
    }
    for (const core::Vec3& corner : corners) {
        const double along = beam.forward ? corner[beam.axis] : -corner[beam.axis];
        for (int a = 0; a < 3; ++a) {
            const double slope = corner[a] / along;
            if (!(along > 0) || !(std::abs(slope) <= kMaxSlope))
                return false;
            beam.slope_min[a] = std::min(beam.slope_min[a], slope);
            beam.slope_max[a] = std::max(beam.slope_max[a], slope);
        }
    }
    return true;
}

bool BeamStart::place(core::RayState& ray, const LevelCut& cut) const noexcept {
    if (kind == Kind::kMiss)
        return false;
    voxel::VoxelBounds bounds = cut.entry_bounds();
    const auto i = static_cast<std::size_t>(axis);
    if (kind == Kind::kPlane) {
        if (forward)
            bounds.min[i] = std::max(bounds.min[i], plane);
        else
            bounds.max[i] = std::min(bounds.max[i], plane);
    }
    return ray.enter(bounds);
}

BeamStart BeamMarch::march(const Beam& beam, const BeamStart& from) {
    const auto axis = static_cast<std::size_t>(beam.axis);
    const int u = (beam.axis + 1) % 3;
    const int w = (beam.axis + 2) % 3;
    const int towards = beam.forward ? 1 : -1;
    const voxel::VoxelBounds& bounds = m_cut.entry_bounds();
    const std::int32_t end = beam.forward ? bounds.max[axis] : bounds.min[axis];
    std::int32_t plane;
    if (from.kind == BeamStart::Kind::kPlane && from.axis == beam.axis) {
        plane = from.plane;
    } else {
        const double eye = std::clamp(beam.eye[axis], static_cast<double>(bounds.min[axis]),
                                      static_cast<double>(bounds.max[axis]));
        // From a little behind the eye, so that thick slabs come soon.
        plane = static_cast<std::int32_t>(beam.forward ? std::floor(eye) : std::ceil(eye));
        plane =
            beam.forward ? plane & ~(kFirstSlab - 1) : (plane + kFirstSlab - 1) & ~(kFirstSlab - 1);
    }
    const auto free_between = [&](std::int32_t near, std::int32_t far, int shift) {
        // What lies behind the eye is not in the beam; the first slab may begin there.
        const double d0 = std::max(0.0, towards * (near - beam.eye[axis]));
        const double d1 = std::max(0.0, towards * (far - beam.eye[axis]));
        VoxelRange range;
        range.low[axis] = std::min(near, far);
        range.high[axis] = std::max(near, far) - 1;
        for (const int a : {u, w}) {
            range.low[a] = core::RayState::floor_to_int(
                beam.eye[a] + std::min(d0 * beam.slope_min[a], d1 * beam.slope_min[a]) -
                kSlabRounding_voxel);
            range.high[a] = core::RayState::floor_to_int(
                beam.eye[a] + std::max(d0 * beam.slope_max[a], d1 * beam.slope_max[a]) +
                kSlabRounding_voxel);
        }
        ++m_slabs;
        return !m_query.any_solid(range, grain_of_slab(shift));
    };
    const bool stopped = march_slabs(plane, end, towards, m_query, kMaxFineSlabs, free_between);
    BeamStart out;
    out.forward = beam.forward;
    out.axis = static_cast<std::int8_t>(beam.axis);
    out.plane = plane;
    out.kind = stopped ? BeamStart::Kind::kPlane : BeamStart::Kind::kMiss;
    return out;
}

}  // namespace terravox::walk
