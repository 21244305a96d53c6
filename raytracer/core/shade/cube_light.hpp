#pragma once

#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/shade/sampler.hpp"

namespace terravox::shade {

/// A direction to a cube, and what the cube brings to a matt white face by way of it: the estimate
/// of an integral over the directions, for light of 1 on all of the cube.
struct TowardsCube {
    core::Vec3 direction;
    double distance = 0;  ///< to the cube
    double share = 0;     ///< 0: nothing
};

/// Chooses such a direction.
/// @param to the cube's middle, from a point of the face that is outside of the cube
/// @param normal of the face
[[nodiscard]] TowardsCube towards_cube(core::Vec3 to, double edge, core::Vec3 normal,
                                       Sampler::Pair at) noexcept;

}  // namespace terravox::shade
