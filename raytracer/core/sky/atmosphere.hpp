#pragma once

#include <array>
#include <vector>

#include "common/voxel/colour.hpp"

namespace terravox::sky {

inline constexpr int kBands = 11;  ///< of light, each kBandWidth_nm wide
inline constexpr double kBandWidth_nm = 30;

/// A value for each band: 390 to 420 nm, ... 690 to 720 nm.
using Spectrum = std::array<double, kBands>;

/// @return the middle of a band, nm
[[nodiscard]] constexpr double wavelength_nm(int band) noexcept {
    return 405 + kBandWidth_nm * band;
}

/// The sun's light above the air, W / (m^2 nm) on a surface that faces it: means over the bands.
/// Ref: ASTM G173-03, extraterrestrial column.
inline constexpr Spectrum kSolarIrradiance = {1.5351, 1.7377, 2.0258, 1.9362, 1.8638, 1.8453,
                                              1.8103, 1.7106, 1.5909, 1.5138, 1.4087};

/// Absorption cross-section of ozone, m^2 per molecule, means over the bands. Ref: Serdyuchenko et
/// al., "High spectral resolution ozone absorption cross-sections", AMT 2014 (rounded, 223 K).
inline constexpr Spectrum kOzoneCrossSection_m2 = {1.65e-27, 9.93e-27, 3.64e-26, 1.05e-25,
                                                   2.17e-25, 3.62e-25, 4.59e-25, 4.35e-25,
                                                   2.71e-25, 1.51e-25, 7.81e-26};

/// Converts spectral radiance, W / (m^2 sr nm), to linear Rec. 709, balanced so that the sun's
/// light above the air is white, as with a camera set to daylight. Components may be negative for
/// light purer than the primaries. The unit of the result is about 1 / 683 cd / m^2.
[[nodiscard]] voxel::Colour to_rec709(const Spectrum& s) noexcept;

/// Desaturates the colour just so far that no component is below 4 % of its luminance, which is
/// kept. Black if the luminance is negative or NaN.
[[nodiscard]] voxel::Colour in_gamut(voxel::Colour c) noexcept;

/// The air of a round Earth: what it scatters and absorbs at each height. Molecules (Rayleigh) and
/// haze (Mie) thin out exponentially, ozone lies in a layer around 25 km. Heights in metres above
/// the sea, lengths in metres. Immutable, thread-safe. Ref: Bruneton & Neyret, "Precomputed
/// atmospheric scattering", EGSR 2008 (model and numbers); Preetham, Shirley, Smits, "A practical
/// analytic model for daylight", SIGGRAPH 1999 (turbidity to Angstrom's coefficient).
class Atmosphere {
public:
    /// Radius of the ground; height of the top of the air.
    static constexpr double kEarth_m = 6'360'000;
    static constexpr double kThick_m = 100'000;
    static constexpr double kSunRadius_rad = 0.004653;
    /// Height over which the density of the molecules falls to 1 / e.
    static constexpr double kRayleighScale_m = 8000;
    /// The same for haze, which fills the mixed layer of a summer's day; the 1.2 km that much of
    /// the literature uses would veil hills 3 km away.
    static constexpr double kMieScale_m = 2000;

    /// @param turbidity [1, 20]: 2 very clear, 6 hazy
    explicit Atmosphere(double turbidity);

    /// Density of each substance, relative to that where it is densest.
    struct Densities {
        double rayleigh = 0;
        double mie = 0;
        double ozone = 0;
    };
    [[nodiscard]] static Densities densities(double height_m) noexcept;

    /// Per metre at density 1.
    [[nodiscard]] const Spectrum& rayleigh() const noexcept { return m_rayleigh; }
    [[nodiscard]] const Spectrum& mie_scattering() const noexcept { return m_mie_scattering; }
    [[nodiscard]] const Spectrum& mie_extinction() const noexcept { return m_mie_extinction; }
    [[nodiscard]] Spectrum extinction(const Densities& at) const noexcept;
    /// Share of light that horizontal ground reflects.
    [[nodiscard]] static const Spectrum& ground_albedo() noexcept;

    /// Share of light that reaches a height from the top of the air.
    /// @param sine of the elevation that the light comes from; directions below the one that grazes
    /// the ground count as that one
    [[nodiscard]] Spectrum transmittance(double height_m, double sine) const noexcept;
    /// Sunlight that arrives at a height on a surface facing it, as a share of that above the air;
    /// smooth while the disc sets behind the round Earth.
    /// @param sine of the sun's altitude there
    [[nodiscard]] Spectrum sunlight(double height_m, double sine) const noexcept;

private:
    Spectrum m_rayleigh;
    Spectrum m_mie_scattering;
    Spectrum m_mie_extinction;
    Spectrum m_ozone;
};

/// Phase function of molecules: share of scattered light per steradian at an angle; integrates to 1
/// over all directions.
/// @param c cosine of the angle, [-1, 1]
[[nodiscard]] double rayleigh_phase(double c) noexcept;
/// Phase function of haze, mostly forward. Ref: Cornette & Shanks, "Physically reasonable analytic
/// expression for the single-scattering phase function", 1992.
[[nodiscard]] double mie_phase(double c) noexcept;

}  // namespace terravox::sky
