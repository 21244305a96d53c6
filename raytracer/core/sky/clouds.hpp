#pragma once

#include "raytracer/core/base/ray.hpp"

namespace terravox::sky {

/// One layer of cumulus: its thickness over each place. A pure function of the place, unbounded.
/// Immutable, thread-safe. Ref: Perlin, "An image synthesizer", SIGGRAPH 1985 (fractal sums of
/// gradient noise).
class Clouds {
public:
    /// @param cover share of the sky that they cover, [0, 1]; 0: none
    explicit Clouds(double cover);

    [[nodiscard]] bool any() const noexcept { return m_cover > 0; }
    /// @return optical depth, straight up, [0, kThickest]
    /// @param x_m, z_m east and south, metres; beyond 1e9 there are no clouds
    [[nodiscard]] double depth(double x_m, double z_m) const noexcept;
    /// From coarse features only, for the clouds towards the sun. Cheaper.
    [[nodiscard]] double coarse_depth(double x_m, double z_m) const noexcept {
        return depth_of(noise(x_m, z_m, 4));
    }
    /// Share of direct light that passes straight through, averaged over places.
    [[nodiscard]] double mean_passing() const noexcept { return m_mean_passing; }

    static constexpr double kThickest = 24;

private:
    [[nodiscard]] static double noise(double x_m, double z_m, int octaves) noexcept;
    [[nodiscard]] double depth_of(double noise) const noexcept;
    double m_cover;
    double m_threshold = 0;
    double m_mean_passing = 1;
};

}  // namespace terravox::sky
