#pragma once

#include <cmath>
#include <optional>

#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/shade/sampler.hpp"

namespace terravox::shade {

/// Directions are of unit length; normals point to the side that the light comes from.

/// Share of unpolarised light that a smooth face reflects. Ref: Fresnel's equations.
/// @param cos_in of the angle to the normal, [0, 1]
/// @param index of the medium behind the face over that in front of it, > 0
/// @return [0, 1]; 1 where reflection is total
[[nodiscard]] inline double fresnel(double cos_in, double index) noexcept {
    const double sin2 = (1 - cos_in * cos_in) / (index * index);
    if (sin2 >= 1)
        return 1;
    const double cos_out = std::sqrt(1 - sin2);
    const double s = (cos_in - index * cos_out) / (cos_in + index * cos_out);
    const double p = (index * cos_in - cos_out) / (index * cos_in + cos_out);
    return (s * s + p * p) / 2;
}

[[nodiscard]] inline core::Vec3 reflect(core::Vec3 d, core::Vec3 n) noexcept {
    return d - n * (2 * core::dot(d, n));
}

/// Snell's law.
/// @return nullopt: total reflection
[[nodiscard]] inline std::optional<core::Vec3> refract(core::Vec3 d, core::Vec3 n,
                                                       double index) noexcept {
    const double eta = 1 / index;
    const double c = -core::dot(d, n);
    const double k = 1 - eta * eta * (1 - c * c);
    if (k <= 0)
        return std::nullopt;
    return core::normalized(d * eta + n * (eta * c - std::sqrt(k)));
}

/// Two directions that form a right-handed frame with n.
/// Ref: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
struct Frame {
    explicit Frame(core::Vec3 n) noexcept : normal(n) {
        const double sign = std::copysign(1.0, n.z);
        const double a = -1 / (sign + n.z);
        const double b = n.x * n.y * a;
        tangent = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
        bitangent = {b, sign + n.y * n.y * a, -n.y};
    }
    [[nodiscard]] core::Vec3 to_world(double x, double y, double z) const noexcept {
        return tangent * x + bitangent * y + normal * z;
    }
    core::Vec3 normal;
    core::Vec3 tangent;
    core::Vec3 bitangent;
};

/// A direction about n with density cos / pi.
[[nodiscard]] core::Vec3 cosine_direction(core::Vec3 n, Sampler::Pair at) noexcept;

/// The normal of a facet of a rough face, about n, distributed by the area visible to a
/// perpendicular view (D cos). Ref: Walter et al., "Microfacet Models for Refraction through Rough
/// Surfaces", EGSR 2007.
/// @param roughness [0, 1]; its square is GGX's alpha
[[nodiscard]] core::Vec3 facet_normal(core::Vec3 n, double roughness, Sampler::Pair at) noexcept;

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
