#pragma once

#include <vector>

#include "raytracer/core/ray.hpp"
#include "raytracer/sky/spectrum.hpp"

namespace terravox::sky {

/// The air of a round Earth: what it scatters and absorbs at a height. Molecules (Rayleigh) and
/// haze (Mie) thin out exponentially, ozone lies in a layer around 25 km. Heights in metres above
/// the sea, lengths in metres. Immutable, thread-safe. Ref: Bruneton & Neyret, "Precomputed
/// atmospheric scattering", EGSR 2008 (model and numbers); Preetham, Shirley, Smits, "A practical
/// analytic model for daylight", SIGGRAPH 1999 (turbidity to Angstrom's coefficient).
class Atmosphere {
public:
    static constexpr double kEarth_m = 6'360'000,
                            kThick_m =
                                100'000;  ///< radius of the ground; height where the air ends
    static constexpr double kSunRadius_rad = 0.004653;
    static constexpr double kRayleighScale_m =
        8000;  ///< height in which the air thins out to 1 / e
    /// The same of haze, which fills the mixed layer of a summer's day; 1.2 km, as in much of the
    /// literature, veils hills 3 km away.
    static constexpr double kMieScale_m = 2000;

    /// @param turbidity [1, 20]: 2 very clear, 6 hazy
    explicit Atmosphere(double turbidity);

    /// How dense each substance is, relative to the place where it is densest.
    struct Densities {
        double rayleigh = 0, mie = 0, ozone = 0;
    };
    [[nodiscard]] static Densities densities(double height_m) noexcept;

    /// Per metre at density 1.
    [[nodiscard]] const Spectrum& rayleigh() const noexcept { return m_rayleigh; }
    [[nodiscard]] const Spectrum& mie_scattering() const noexcept { return m_mie_scattering; }
    [[nodiscard]] const Spectrum& mie_extinction() const noexcept { return m_mie_extinction; }
    [[nodiscard]] Spectrum extinction(const Densities& at) const noexcept;
    /// Share of light that a horizontal ground throws back.
    [[nodiscard]] static const Spectrum& ground_albedo() noexcept;

    /// Share of light that comes down from the end of the air to a height. @param sine of the
    /// elevation it comes from; lines that would meet the ground count as those that graze it
    [[nodiscard]] Spectrum transmittance(double height_m, double sine) const noexcept;
    /// Sunlight that arrives at a height on a surface facing it, as a share of that above the air;
    /// smooth while the disc sets behind the round Earth. @param sine of the sun's altitude there
    [[nodiscard]] Spectrum sunlight(double height_m, double sine) const noexcept;

private:
    Spectrum m_rayleigh, m_mie_scattering, m_mie_extinction, m_ozone;
};

/// Share of scattered light that goes at an angle, 1 / sr; over all directions 1. @param c cosine
/// of the angle, [-1, 1]
[[nodiscard]] double rayleigh_phase(double c) noexcept;
/// Of haze, forward. Ref: Cornette & Shanks, "Physically reasonable analytic expression for the
/// single-scattering phase function", 1992.
[[nodiscard]] double mie_phase(double c) noexcept;

}  // namespace terravox::sky
