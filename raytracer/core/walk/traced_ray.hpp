#pragma once

#include <cstdint>

#include "common/voxel/colour.hpp"
#include "raytracer/core/walk/fan.hpp"
#include "raytracer/core/walk/lamp_choice.hpp"
#include "raytracer/core/walk/surroundings.hpp"

namespace terravox::walk {

enum class RayKind : std::uint8_t {
    kPrimary,
    kShadow,     ///< towards the sun: only whether it is free
    kSky,        ///< towards a point of the sky: only whether it is free
    kMirror,     ///< reflected by a smooth face
    kRefracted,  ///< into water, ice or glass, or out of it
    kAmbient,    ///< ambient occlusion: only whether it is free up to t_max
    kBounce,     ///< of a path, from a matt face
    kLamp,       ///< towards a lamp: only whether it is free up to t_max
};
inline constexpr std::size_t kRayKinds = 8;
[[nodiscard]] constexpr const char* name_of(RayKind kind) noexcept {
    constexpr const char* names[kRayKinds] = {"primary",   "shadow",  "sky",    "mirror",
                                              "refracted", "ambient", "bounce", "lamp"};
    return names[static_cast<std::size_t>(kind)];
}

/// A ray of a wave: where it is, the weight of its result, and the result. A plain value: it may
/// wait for a box and continue later.
struct TracedRay {
    core::RayState state;
    core::Ray ray;  ///< as it was emitted; level-0 voxels, of unit length
    /// Share of the light it finds that reaches its sample; for occlusion rays, the light that
    /// arrives if nothing is in between.
    voxel::Colour weight;
    double t_max = core::kFar;  ///< of rays to lamps, and ambient ones
    std::uint32_t sample = 0;   ///< index within the round
    std::uint32_t stream = 0;   ///< selects its random numbers; of a fan, its directions
    float footprint = 0;        ///< what its pixel covers at its origin, level-0 voxels
    float spread = 0;           ///< growth of the footprint for each voxel on its way
    /// Probability density, per steradian, with which its direction was chosen; 0: there was no
    /// choice.
    float density = 0;
    RayKind kind = RayKind::kPrimary;
    WalkEnd end = WalkEnd::kWaits;
    std::uint8_t depth = 0;  ///< number of faces that have reflected or refracted it
    /// Of a fan: which directions of its stream it sends a ray in. 0: this is one ray. A fan starts
    /// at `ray.origin`, in the voxel of `state`; its direction, `end` and `hit` mean nothing, and
    /// its weight is for its evaluator to use.
    FanMask fan_mask = 0;
    bool direct = true;  ///< its light reached the first hit without a detour
    /// For occlusion rays: leaves may let the ray pass, so the voxel that it hits must be known.
    bool leaves = false;
    /// For paths: the sunlight that the ray may reach was sampled at its origin, in water.
    bool sun_counted = false;
    voxel::Material medium = voxel::Material::kAir;  ///< that it passes through
    StopAt stop;
    /// For paths: lamps whose middle is this near to the ray's origin were sampled there, level-0
    /// voxels.
    float lamps_reach = 0;
    Seen around;      ///< the voxels around the one in front of the face
    LampChoice lamp;  ///< for the point that it hits
    /// Valid with kHit; of occlusion rays only `hole`, unless `leaves`.
    Hit hit;

    [[nodiscard]] bool is_fan() const noexcept { return fan_mask != 0; }
    /// Whether it is an occlusion ray: only whether it is free matters.
    [[nodiscard]] bool is_occlusion() const noexcept {
        return kind == RayKind::kShadow || kind == RayKind::kSky || kind == RayKind::kAmbient ||
               kind == RayKind::kLamp;
    }
    /// Whether only the existence of a hit matters, not what was hit.
    [[nodiscard]] bool only_blocked() const noexcept {
        return is_occlusion() && !leaves && stop == StopAt::kSolid;
    }
};

}  // namespace terravox::walk
