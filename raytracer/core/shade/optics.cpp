#include "raytracer/core/shade/optics.hpp"

#include "common/util/det_math.hpp"

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

}  // namespace terravox::shade
