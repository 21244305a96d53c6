#include "raytracer/analyse/sky_directions.hpp"

#include <array>
#include <cmath>
#include <numeric>

#include "common/util/det_math.hpp"
#include "raytracer/core/random.hpp"

namespace terravox::analyse {
namespace {

/// The generator of a lattice of `count` points: coprime with it, and near its golden section,
/// where the points lie most evenly. Ref: Korobov lattices; for Fibonacci numbers this is the
/// Fibonacci lattice.
int lattice_generator(int count) {
    constexpr double kGolden = 0.6180339887498949;
    const int ideal = static_cast<int>(count * kGolden + 0.5);
    for (int off = 0;; ++off)
        for (const int g : {ideal + off, ideal - off})
            if (g > 0 && g < count + 1 && std::gcd(g, count) == 1)
                return g;
}

double fraction_of(double v) noexcept {
    return v - std::floor(v);
}

}  // namespace

SkyDirections::SkyDirections(int count) : m_count(static_cast<std::size_t>(count)) {
    m_directions.reserve(kSets * m_count);
    const std::int64_t generator = lattice_generator(count);
    for (std::size_t set = 0; set < kSets; ++set) {
        const double shift_u = core::unit_from(core::hash64(2 * set));
        const double shift_v = core::unit_from(core::hash64(2 * set + 1));
        double sum[3] = {};
        std::vector<std::array<double, 3>> weights;
        weights.reserve(m_count);
        for (std::int64_t i = 0; i < count; ++i) {
            // Within their strata points lie off the zenith and off the horizon.
            const double u = fraction_of(static_cast<double>(i) / count + shift_u);
            const double v =
                fraction_of(static_cast<double>(i * generator % count) / count + shift_v);
            const det::SinCos zenith = det::sin_cos(u * det::kPi / 2);
            const det::SinCos azimuth = det::sin_cos(2 * det::kPi * v);
            m_directions.push_back(
                {{zenith.sin * azimuth.cos, zenith.cos, zenith.sin * azimuth.sin}, {}});
            weights.push_back({zenith.sin * zenith.cos, zenith.sin, 1});
            for (std::size_t m = 0; m < 3; ++m)
                sum[m] += weights.back()[m];
        }
        for (std::size_t i = 0; i < m_count; ++i)
            m_directions[set * m_count + i].share = {static_cast<float>(weights[i][0] / sum[0]),
                                                     static_cast<float>(weights[i][1] / sum[1]),
                                                     static_cast<float>(weights[i][2] / sum[2])};
    }
}

std::span<const SkyDirection> SkyDirections::of(std::uint64_t cell) const noexcept {
    const std::size_t set = core::hash64(cell) % kSets;
    return std::span(m_directions).subspan(set * m_count, m_count);
}

}  // namespace terravox::analyse
