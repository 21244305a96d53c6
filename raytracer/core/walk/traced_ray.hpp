#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "common/voxel/box.hpp"
#include "common/voxel/colour.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/base/ray_state.hpp"
#include "raytracer/core/walk/surroundings.hpp"

namespace terravox::walk {

// A fan is rays from one point in a few directions, of which only matters whether they are free.
// Many points have fans of the same directions: their rays are walked together, direction by
// direction, and while they wait a fan is one TracedRay instead of many.

inline constexpr std::size_t kFanRays = 16;
/// A bit for each direction of a fan, the lowest for the first one.
using FanMask = std::uint16_t;

/// Directions that fans have in common.
struct FanDirections {
    std::array<core::Vec3, kFanRays> to;  ///< of unit length
    std::size_t count = 0;

    void add(const core::Vec3& direction) noexcept { to[count++] = direction; }
};

/// The mask of the first `count` directions, of at most kFanRays.
[[nodiscard]] constexpr FanMask mask_of_first(std::size_t count) noexcept {
    return static_cast<FanMask>((std::uint32_t{1} << count) - 1);
}
[[nodiscard]] constexpr bool has(FanMask mask, std::size_t direction) noexcept {
    return (mask >> direction & 1U) != 0;
}

/// What became of the rays of a fan.
struct FanEnds {
    FanMask blocked = 0;
    FanMask holes = 0;  ///< of the blocked ones, those that met a box that is not available
};

/// A voxel that emits light.
struct LampVoxel {
    core::VoxelCoord voxel;  ///< of `level`
    int level = 0;
    voxel::VoxelAttr attr;

    /// Edge, level-0 voxels.
    [[nodiscard]] double edge() const noexcept {
        return static_cast<double>(std::int64_t{1} << level);
    }
    /// Level-0 voxels.
    [[nodiscard]] core::Vec3 middle() const noexcept {
        const double size = edge();
        return {(voxel.x + 0.5) * size, (voxel.y + 0.5) * size, (voxel.z + 0.5) * size};
    }
};

/// A lamp that was chosen for a point.
struct LampChoice {
    LampVoxel lamp;
    float probability = 0;  ///< of the choice; 0: none was chosen
    /// Whether lamps near the point are sampled. They are not where there are very many: their
    /// light is met by chance.
    bool looked = false;
};

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
[[nodiscard]] constexpr const char* to_name(RayKind kind) noexcept {
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
