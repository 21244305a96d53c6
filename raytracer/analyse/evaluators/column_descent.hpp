#pragma once

#include "raytracer/core/base/scene_words.hpp"
#include "raytracer/core/shade/view.hpp"
#include "raytracer/core/walk/traced_ray.hpp"

namespace terravox::analyse {

// A cell is measured by one ray straight down through its middle. Where the ground is wanted, the
// ray goes on below whatever else it meets, one voxel after the other.

/// A coordinate, rounded to 1/1024 of a voxel: on the boundary between two voxels rounding must not
/// choose one of them. An exact boundary belongs to the voxel east or south of it.
[[nodiscard]] double on_grid(double at) noexcept;

/// The vertical ray of a cell, from a ray of the camera.
[[nodiscard]] walk::TracedRay cell_ray(const core::Ray& ray, std::uint32_t sample) noexcept;

/// Distance of neighbouring cells, level-0 voxels.
[[nodiscard]] double cell_spacing(const shade::View& view) noexcept;

/// A vertical ray at a distance from another ray, from above the world. Outside of the world it has
/// ended already.
/// @param east, south of the other's origin, level-0 voxels
[[nodiscard]] walk::TracedRay ray_beside(const shade::View& view, const walk::TracedRay& ray,
                                         double east, double south) noexcept;

/// The voxel of a level that holds a point.
/// @param at level-0 voxels
[[nodiscard]] core::VoxelCoord voxel_at(core::Vec3 at, int level) noexcept;

/// Whether a ray has ended at a box that is not available.
[[nodiscard]] inline bool is_hole(const walk::TracedRay& ray) noexcept {
    return ray.end == walk::WalkEnd::kHit && ray.hit.hole;
}

/// Height of the top of the voxel that a vertical ray has met, level-0 voxels.
[[nodiscard]] double top_of(const walk::Hit& hit) noexcept;

/// Whether a material is the surface of terrain: ground of any kind, water, ice.
[[nodiscard]] bool is_ground(voxel::Material material) noexcept;

enum class Descent : std::uint8_t {
    kGround,  ///< the ray has met the ground
    /// The ground is below here, but its height is unknown: inside of what is opaque on all sides,
    /// such as a building, boxes hold no materials.
    kCovered,
    kContinues,
};
/// What a vertical ray's hit, which must not be a hole, means for the search for the ground.
/// @param ray of cell_ray() or below()
[[nodiscard]] Descent descent_at(const walk::TracedRay& ray) noexcept;

/// What a vertical ray means for an analysis that measures at one point of the cell.
enum class CellStep : std::uint8_t {
    kMeasure,  ///< at the top of the voxel that it has met
    kDescend,  ///< further down: below()
    kNothing,  ///< nowhere: the cell has no value
};
/// @param ray at its end
[[nodiscard]] CellStep cell_step_at(const walk::TracedRay& ray,
                                    core::AnalysisSurface surface) noexcept;

/// Whether a ray to the sun or the sky, at its end, has met nothing: no voxel, and no terrain
/// outside of the data.
[[nodiscard]] bool is_free(const walk::TracedRay& ray, const shade::View& view) noexcept;

/// The ray that goes on below the voxel that a vertical ray has met.
[[nodiscard]] walk::TracedRay below(const walk::TracedRay& ray) noexcept;

}  // namespace terravox::analyse
