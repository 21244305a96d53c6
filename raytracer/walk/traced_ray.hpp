#pragma once

#include <cstdint>

#include "common/voxel/colour.hpp"
#include "raytracer/walk/surroundings.hpp"

namespace terravox::walk {

enum class RayKind : std::uint8_t {
    kPrimary,
    kShadow,     ///< towards the sun: free or not
    kSky,        ///< towards a place of the sky: free or not
    kMirror,     ///< thrown back by a smooth face
    kRefracted,  ///< into water, ice or glass, or out of it
    kAmbient,    ///< ambient occlusion: free as far as t_max or not
    kBounce,     ///< of a path, from a matt face
};
inline constexpr std::size_t kRayKinds = 7;
[[nodiscard]] constexpr const char* name_of(RayKind kind) noexcept {
    constexpr const char* names[kRayKinds] = {"primary",   "shadow",  "sky",   "mirror",
                                              "refracted", "ambient", "bounce"};
    return names[static_cast<std::size_t>(kind)];
}

/// A ray of a wave: where it is, what its result is worth, and the result. A plain value: it may
/// wait for a box and go on later.
struct TracedRay {
    core::RayState state;
    core::Ray ray;              ///< as it was sent, level-0 voxels, of unit length
    voxel::Colour weight;       ///< share of what it brings that reaches its sample; of shadow and
                                ///< ambient rays: the light that comes if nothing is between
    double t_max = core::kFar;  ///< of ambient rays
    std::uint32_t sample = 0;   ///< index within the round
    std::uint32_t stream = 0;   ///< which random numbers are its own
    float footprint = 0;        ///< what its pixel covers where it was sent, level-0 voxels
    float spread = 0;           ///< how much more that is for each voxel on its way
    float density =
        0;  ///< per steradian, with which its direction was chosen; 0: there was no choice
    RayKind kind = RayKind::kPrimary;
    WalkEnd end = WalkEnd::kWaits;
    std::uint8_t depth = 0;  ///< faces that threw it back or let it in
    bool direct = true;  ///< what it brings is light that came to the first hit without a detour
    bool leaves =
        false;  ///< of rays that ask: leaves may let it pass, so that the voxel it meets counts
    bool sun_asked = false;  ///< of paths: the sun that it may come to has been counted where it
                             ///< was sent, in water
    voxel::Material medium = voxel::Material::kAir;  ///< that it runs through
    StopAt stop;
    Seen around;  ///< the voxels around the one before the face
    Hit hit;      ///< with kHit, of rays that ask only `hole`, but for `leaves`

    /// Whether it only asks for light: free or not.
    [[nodiscard]] bool asks() const noexcept {
        return kind == RayKind::kShadow || kind == RayKind::kSky || kind == RayKind::kAmbient;
    }
    /// Whether what stops it does not count.
    [[nodiscard]] bool only_blocked() const noexcept {
        return asks() && !leaves && stop == StopAt::kSolid;
    }
};

}  // namespace terravox::walk
