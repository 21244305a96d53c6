#pragma once

#include "raytracer/shade/view.hpp"
#include "raytracer/walk/traced_ray.hpp"

namespace terravox::shade {

/// What the face is like that a ray has met.
struct Surface {
    core::Vec3 point;          ///< level-0 voxels
    core::Vec3 normal;         ///< of the face, towards where the ray came from
    core::Vec3 smooth_normal;  ///< with waves on it
    core::Vec3 direction;      ///< of the ray
    voxel::Colour albedo, emission;
    float opacity = 1;    ///< leaves: share that stops a ray
    float polish = 0;     ///< share of the face that reflects as a smooth coat
    float roughness = 0;  ///< of that coat
    double index = 1;     ///< of refraction
    bool transparent = false, leaves = false;
};

/// What light goes through inside transparent materials.
struct Medium {
    voxel::Colour absorption_per_m;
    voxel::Colour glow;  ///< what bottomless depth sends back, of the light that comes from above
    double index = 1;    ///< of refraction; 1 for air
};
[[nodiscard]] Medium medium_of(const View& view, voxel::Material material) noexcept;

/// Light goes through it: water, ice, glass.
[[nodiscard]] bool is_transparent(const View& view, voxel::Material material) noexcept;
/// Rays may pass between its leaves.
[[nodiscard]] bool has_holes(const View& view, voxel::Material material) noexcept;

/// The surface at a ray's hit, which is neither a hole nor without a face.
[[nodiscard]] Surface surface_at(const View& view, const walk::TracedRay& ray);

/// What a pixel covers at a ray's hit, level-0 voxels.
[[nodiscard]] inline float footprint_at(const walk::TracedRay& ray) noexcept {
    return ray.footprint + ray.spread * static_cast<float>(ray.hit.t);
}

/// Whether what is drawn on the face depends on what stands around it: a roof's tiles lie along its
/// slope.
[[nodiscard]] bool shows_slope(const View& view, const walk::Hit& hit) noexcept;

/// Share of ambient light at a point of a face whose corners are darkened by what stands around.
/// @param bits see Surroundings
[[nodiscard]] float open_share(const walk::Hit& hit, core::Vec3 point, std::uint8_t bits) noexcept;

}  // namespace terravox::shade
