#pragma once

#include <array>

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

}  // namespace terravox::sky
