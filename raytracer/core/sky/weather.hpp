#pragma once

#include <optional>

#include "common/voxel/colour.hpp"
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
        return find_depth(noise(x_m, z_m, 4));
    }
    /// Share of direct light that passes straight through, averaged over places.
    [[nodiscard]] double mean_passing() const noexcept { return m_mean_passing; }

    static constexpr double kThickest = 24;

private:
    [[nodiscard]] static double noise(double x_m, double z_m, int octaves) noexcept;
    [[nodiscard]] double find_depth(double noise) const noexcept;
    double m_cover;
    double m_threshold = 0;
    double m_mean_passing = 1;
};

/// How the air near the ground attenuates what lies behind it, for the three channels. Immutable,
/// thread-safe. Ref: Koschmieder, "Theorie der horizontalen Sichtweite", 1924 (visibility).
class Haze {
public:
    /// @param turbidity as of the Atmosphere
    /// @param place_height_m above the sea
    /// @param visibility_km > 0: distance at which a level line of sight transmits 5 % in the green
    /// channel; nullopt: derived from turbidity
    Haze(double turbidity, double place_height_m, std::optional<double> visibility_km);
    /// Transmittance along a line whose lower end is at the place's height; 1 for 0 metres, 0 for
    /// infinity.
    /// @param direction of unit length
    [[nodiscard]] voxel::Colour transmittance(core::Vec3 direction, double metres) const noexcept;

    /// Extinction by molecules and by haze, at the place's height.
    [[nodiscard]] voxel::Colour rayleigh_per_m() const noexcept { return m_rayleigh_per_m; }
    [[nodiscard]] voxel::Colour mie_per_m() const noexcept { return m_mie_per_m; }

private:
    voxel::Colour m_rayleigh_per_m;
    voxel::Colour m_mie_per_m;
};

}  // namespace terravox::sky
