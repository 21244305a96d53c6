#pragma once

#include <span>
#include <vector>

#include "common/voxel/colour.hpp"
#include "raytracer/core/base/ray.hpp"

namespace terravox::sky {

/// Light from approximately one direction.
struct LightFrom {
    core::Vec3 direction;  ///< of unit length
    voxel::Colour radiance;
    double solid_angle;  ///< steradians
};

/// The light that a white Lambertian surface reflects under light from all around, for every
/// normal: a table over the octahedron, exact for the normals of a voxel's faces up to the sum over
/// the light given. Immutable, thread-safe. Ref: Meyer et al., "On floating-point normal vectors",
/// EGSR 2010 (the octahedral map).
class AmbientTable {
public:
    AmbientTable() = default;  ///< darkness
    explicit AmbientTable(std::span<const LightFrom> light);
    /// @param normal of any length except 0
    [[nodiscard]] voxel::Colour at(core::Vec3 normal) const noexcept;

private:
    std::vector<voxel::Colour> m_nodes;
};

}  // namespace terravox::sky
