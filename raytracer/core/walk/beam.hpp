#pragma once

#include "raytracer/core/base/ray_state.hpp"
#include "raytracer/core/walk/solid_query.hpp"

namespace terravox::walk {

/// The rays of a rectangle of pixels together: all points that lie, from the eye along a major
/// axis, within a range of slopes on the two other axes. Coordinates are level-0 voxels.
struct Beam {
    double eye[3];
    /// Per voxel of the major axis, in the beam's direction; the entries of the major axis are
    /// unused.
    double slope_min[3], slope_max[3];
    int axis = 0;
    bool forward = true;

    /// @param corners directions of the rays through the rectangle's corners
    /// @return false when they have no major axis in common
    [[nodiscard]] static bool make(core::Vec3 eye, const core::Vec3 (&corners)[4],
                                   Beam& beam) noexcept;
};

/// How far a beam is free: no ray of it meets anything before it crosses the plane `axis = plane`.
struct BeamStart {
    enum class Kind : std::uint8_t {
        kEye,  ///< nothing is known: rays start at the eye
        kPlane,
        kMiss,  ///< free until the end of the world
    };
    Kind kind = Kind::kEye;
    bool forward = true;
    std::int8_t axis = 0;
    std::int32_t plane = 0;

    /// Places a ray of the beam where it may start. From there it meets the same voxels as it would
    /// have met from the eye.
    /// @return false when it never reaches the world
    [[nodiscard]] bool place(core::RayState& ray, const LevelCut& cut) const noexcept;
};

/// Marches beams: slab after slab along the major axis, each as thick as can be shown to be free.
///
/// Ref: the idea of a beam that spares its rays the empty space: Laine & Karras, "Efficient Sparse
/// Voxel Octrees", I3D 2010 (beam optimization). Here it works on masks and in whole voxels, so
/// that no hit changes.
class BeamMarch {
public:
    BeamMarch(BlockReader& reader, const LevelCut& cut) : m_query(reader, cut), m_cut(cut) {}

    /// @param from what is known of a beam that encloses this one
    [[nodiscard]] BeamStart march(const Beam& beam, const BeamStart& from);
    [[nodiscard]] std::uint64_t slabs() const noexcept { return m_slabs; }

private:
    SolidQuery m_query;
    const LevelCut& m_cut;
    std::uint64_t m_slabs = 0;
};

}  // namespace terravox::walk
