#pragma once

#include <cstdint>

#include "raytracer/shade/colour.hpp"
#include "raytracer/walk/surroundings.hpp"

namespace terravox {

enum class RayKind : std::uint8_t {
    kPrimary,
    kShadow,  ///< towards the sun: free or not
    kMirror,  ///< from water
    kBed,     ///< through water to what lies beneath
};
inline constexpr std::size_t kRayKinds = 4;
[[nodiscard]] constexpr const char* name_of(RayKind kind) noexcept {
    constexpr const char* names[kRayKinds] = {"primary", "shadow", "mirror", "bed"};
    return names[static_cast<std::size_t>(kind)];
}

/// A ray of a wave: where it is, what its result is worth, and the result. A plain value: it may wait for a box and go on later.
struct TracedRay {
    RayState state;
    Ray ray;         ///< as it was sent, level-0 voxels
    Colour weight;   ///< share of what it brings that reaches its sample; of a shadow ray: the light that the sun gives if nothing is between
    std::uint32_t sample = 0;  ///< index within the round
    RayKind kind = RayKind::kPrimary;
    WalkEnd end = WalkEnd::kWaits;
    Seen around;  ///< the voxels around the one before the face
    Hit hit;                  ///< with kHit, not of shadow rays
};

}  // namespace terravox
