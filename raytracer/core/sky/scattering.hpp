#pragma once

#include "raytracer/core/sky/atmosphere.hpp"

namespace terravox::sky {

/// Light that arrives along a line of sight, as shares of the sun's above the air, per steradian.
/// `rayleigh` and `mie` have been scattered once and still lack their phase functions; `multiple`
/// is complete.
struct Scattered {
    Spectrum rayleigh{};
    Spectrum mie{};
    Spectrum multiple{};
};

/// Scattered sunlight in the air for one altitude of the sun. Immutable, thread-safe.
/// Ref: Nishita, Sirai, Tadamura, Nakamae, "Display of the Earth taking into account atmospheric
/// scattering", SIGGRAPH 1993 (single scattering); Hillaire, "A scalable and production ready sky
/// and atmosphere rendering technique", EGSR 2020 (multiple scattering).
class Scattering {
public:
    /// @param altitude_rad of the sun at the observer, [-pi / 2, pi / 2]
    /// @param atmosphere must outlive this
    Scattering(const Atmosphere& atmosphere, double altitude_rad);

    /// Light seen by an observer.
    /// @param height_m [0, kThick_m)
    /// @param elevation sine, [0, 1]
    /// @param azimuth_cosine from the sun
    [[nodiscard]] Scattered seen(double height_m, double elevation,
                                 double azimuth_cosine) const noexcept;

private:
    /// Light scattered any number of times: the average over all directions of what arrives.
    [[nodiscard]] Spectrum multiple_at(double height_m, double sun_sine) const noexcept;
    [[nodiscard]] Spectrum gathered(double height_m, double sun_sine) const noexcept;
    const Atmosphere& m_atmosphere;
    core::Vec3 m_to_sun;  ///< x away from the observer, y up
    double m_first_sine;
    double m_last_sine;
    std::vector<Spectrum> m_multiple;
};

}  // namespace terravox::sky
