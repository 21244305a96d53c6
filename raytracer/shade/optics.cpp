#include "raytracer/shade/optics.hpp"

#include <numbers>

#include "common/util/det_math.hpp"

namespace terravox {

// By the octant of the turn: a polynomial over an eighth of it.
Turn::Turn(double u) noexcept {
    const double octants = (u - std::floor(u)) * 8;
    const int octant = static_cast<int>(octants) & 7;
    // Odd octants are run through backwards.
    const double part = (octant & 1) != 0 ? octant + 1 - octants : octants - octant, x = part * (std::numbers::pi / 4), x2 = x * x;
    const double s = x * (1 + x2 * (-1.0 / 6 + x2 * (1.0 / 120 + x2 * (-1.0 / 5040 + x2 * (1.0 / 362880 + x2 * (-1.0 / 39916800 + x2 / 6227020800.0))))));
    const double c = 1 + x2 * (-1.0 / 2 + x2 * (1.0 / 24 + x2 * (-1.0 / 720 + x2 * (1.0 / 40320 + x2 * (-1.0 / 3628800 + x2 / 479001600.0)))));
    switch (octant) {
        case 0: cos = c, sin = s; break;
        case 1: cos = s, sin = c; break;
        case 2: cos = -s, sin = c; break;
        case 3: cos = -c, sin = s; break;
        case 4: cos = -c, sin = -s; break;
        case 5: cos = -s, sin = -c; break;
        case 6: cos = s, sin = -c; break;
        default: cos = c, sin = -s; break;
    }
}

Vec3 cosine_direction(Vec3 n, Sampler::Pair at) noexcept {
    const Turn turn(at.v);
    const double r = std::sqrt(at.u);
    return normalized(Frame(n).to_world(r * turn.cos, r * turn.sin, std::sqrt(std::max(1e-12, 1 - at.u))));
}

Vec3 facet_normal(Vec3 n, double roughness, Sampler::Pair at) noexcept {
    const double alpha = roughness * roughness;
    const double cos2 = (1 - at.u) / (1 + (alpha * alpha - 1) * at.u), sin = std::sqrt(std::max(0.0, 1 - cos2));
    const Turn turn(at.v);
    return normalized(Frame(n).to_world(sin * turn.cos, sin * turn.sin, std::sqrt(cos2)));
}

}  // namespace terravox
