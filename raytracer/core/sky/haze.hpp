#pragma once

#include <optional>

#include "common/voxel/colour.hpp"
#include "raytracer/core/base/ray.hpp"

namespace terravox::sky {

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
