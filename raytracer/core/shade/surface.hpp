#pragma once

#include "raytracer/core/shade/view.hpp"
#include "raytracer/core/walk/traced_ray.hpp"

namespace terravox::shade {

/// Properties of the face that a ray has met.
struct Surface {
    core::Vec3 point;          ///< level-0 voxels
    core::Vec3 normal;         ///< of the face, on the side that the ray came from
    core::Vec3 smooth_normal;  ///< including waves
    core::Vec3 direction;      ///< of the ray
    voxel::Colour albedo;
    voxel::Colour emission;
    float opacity = 1;    ///< leaves: share of rays that it stops
    float polish = 0;     ///< share of the face that reflects like a smooth coat
    float roughness = 0;  ///< of that coat
    double index = 1;     ///< of refraction
    bool transparent = false;
    bool leaves = false;
};

/// Properties of the inside of a transparent material.
struct Medium {
    voxel::Colour absorption_per_m;
    voxel::Colour glow;  ///< share of the light from above that bottomless depth sends back
    double index = 1;    ///< of refraction; 1 for air
};
[[nodiscard]] Medium find_medium(const View& view, voxel::Material material) noexcept;

/// Light that a lamp emits.
[[nodiscard]] voxel::Colour lamp_light(const View& view, const voxel::VoxelAttr& attr) noexcept;

/// Whether light passes through it: water, ice, glass.
[[nodiscard]] bool is_transparent(const View& view, voxel::Material material) noexcept;
/// Whether rays may pass between its leaves.
[[nodiscard]] bool has_holes(const View& view, voxel::Material material) noexcept;

/// The surface at a ray's hit, which must not be a hole and must have a face.
[[nodiscard]] Surface surface_at(const View& view, const walk::TracedRay& ray);

/// Edge of what a pixel covers at a ray's hit, level-0 voxels.
[[nodiscard]] inline float footprint_at(const walk::TracedRay& ray) noexcept {
    return ray.footprint + ray.spread * static_cast<float>(ray.hit.t);
}

/// Whether the texture of the face depends on the voxels around it: a roof's tiles follow its
/// slope.
[[nodiscard]] bool shows_slope(const View& view, const walk::Hit& hit) noexcept;

/// Share of ambient light at a point of a face whose corners are darkened by the voxels around.
/// @param bits see Surroundings
[[nodiscard]] float open_share(const walk::Hit& hit, core::Vec3 point, std::uint8_t bits) noexcept;

}  // namespace terravox::shade
