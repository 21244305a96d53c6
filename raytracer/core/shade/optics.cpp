#include "raytracer/core/shade/optics.hpp"

#include <algorithm>

#include "common/util/det_math.hpp"
#include "raytracer/core/base/ray_state.hpp"

namespace terravox::shade {

core::Vec3 cosine_direction(core::Vec3 n, Sampler::Pair at) noexcept {
    const auto turn = det::sin_cos(2 * det::kPi * at.v);
    const double r = std::sqrt(at.u);
    return core::normalized(
        Frame(n).to_world(r * turn.cos, r * turn.sin, std::sqrt(std::max(1e-12, 1 - at.u))));
}

core::Vec3 facet_normal(core::Vec3 n, double roughness, Sampler::Pair at) noexcept {
    const double alpha = roughness * roughness;
    const double cos2 = (1 - at.u) / (1 + (alpha * alpha - 1) * at.u);
    const double sin = std::sqrt(std::max(0.0, 1 - cos2));
    const auto turn = det::sin_cos(2 * det::kPi * at.v);
    return core::normalized(Frame(n).to_world(sin * turn.cos, sin * turn.sin, std::sqrt(cos2)));
}

namespace {

/// A point of a side, for cubes that are not near.
TowardsCube point_of_cube(core::Vec3 to, double edge, core::Vec3 normal,
                          Sampler::Pair at) noexcept {
    // Sides that are seen, each by how far the face is in front of its plane: so a point's share
    // depends on its distance alone.
    double before[3];
    for (int a = 0; a < 3; ++a)
        before[a] = std::max(std::abs(to[a]) - edge / 2, 0.0);
    const double sum = before[0] + before[1] + before[2];
    double left = at.u * sum;
    int side = 0;
    while (side < 2 && left >= before[side])
        left -= before[side++];
    while (side > 0 && !(before[side] > 0))
        --side;
    const double across = std::min(left / before[side], 1.0) - 0.5;
    core::Vec3 point = to;
    double* const axes[3] = {&point.x, &point.y, &point.z};
    *axes[side] -= std::copysign(edge / 2, to[side]);
    *axes[(side + 1) % 3] += across * edge;
    *axes[(side + 2) % 3] += (at.v - 0.5) * edge;
    TowardsCube out;
    out.distance = core::length(point);
    out.direction = point * (1 / out.distance);
    out.share = std::max(core::dot(out.direction, normal), 0.0) * edge * edge * sum /
                (det::kPi * out.distance * out.distance * out.distance);
    return out;
}

/// The same for a cube so near that its points are at very different distances: a direction of any
/// kind meets it.
TowardsCube chance_of_cube(core::Vec3 to, double edge, core::Vec3 normal,
                           Sampler::Pair at) noexcept {
    TowardsCube out;
    out.direction = cosine_direction(normal, at);
    double entry = 0;
    double exit = core::kFar;
    for (int a = 0; a < 3; ++a) {
        const double d = out.direction[a];
        if (d == 0) {
            if (std::abs(to[a]) > edge / 2)
                return out;
            continue;
        }
        const double one = (to[a] - edge / 2) / d;
        const double other = (to[a] + edge / 2) / d;
        entry = std::max(entry, std::min(one, other));
        exit = std::min(exit, std::max(one, other));
    }
    out.distance = entry;
    out.share = entry > 0 && entry < exit ? 1 : 0;
    return out;
}

bool is_near(core::Vec3 to, double edge) noexcept {
    double far2 = 0;
    for (int a = 0; a < 3; ++a) {
        const double outside = std::max(std::abs(to[a]) - edge / 2, 0.0);
        far2 += outside * outside;
    }
    return far2 < 0.25 * edge * edge;
}

}  // namespace

TowardsCube towards_cube(core::Vec3 to, double edge, core::Vec3 normal, Sampler::Pair at) noexcept {
    return is_near(to, edge) ? chance_of_cube(to, edge, normal, at)
                             : point_of_cube(to, edge, normal, at);
}

}  // namespace terravox::shade
