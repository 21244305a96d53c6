#pragma once

#include <array>
#include <string>

namespace terravox::solar {

/// Power of sunlight, W/m2.
struct Irradiance {
    double beam = 0;     ///< on a surface that faces the sun
    double diffuse = 0;  ///< of the sky, on a level surface
    friend bool operator==(const Irradiance&, const Irradiance&) = default;
};

/// Of a surface that faces the sun outside of the atmosphere, W/m2.
/// @param day_of_year from 1
[[nodiscard]] double extraterrestrial_w_m2(int day_of_year) noexcept;

/// Air that light comes through, as a multiple of that from the zenith; at sea level.
/// Ref: Kasten & Young, "Revised optical air mass tables and approximation formula", 1989.
/// @param altitude_deg with refraction, from 0
[[nodiscard]] double air_mass(double altitude_deg) noexcept;

/// Under a sky without clouds.
/// Ref: Rigollier, Bauer, Wald, "On the clear sky model of the ESRA - European Solar Radiation
/// Atlas - with respect to the Heliosat method", 2000.
/// @param altitude_deg of the sun, with refraction, above 0
/// @param linke turbidity of the air at air mass 2, from 1
/// @param height_m above the sea
[[nodiscard]] Irradiance clear_sky(double altitude_deg, double linke, double height_m,
                                   int day_of_year) noexcept;

/// Linke turbidities of January to December.
/// @param text one number for all, or twelve separated by commas
/// @throws UsageError unless each is 1 to 10
[[nodiscard]] std::array<double, 12> parse_linke(const std::string& text);

/// Where the sky's light comes from, as parts of its light on a level surface.
///
/// A tilted surface gets isotropic * (1 + cos(tilt)) / 2 + around_sun * max(0, cos(angle to the
/// sun)) + horizon * sin(tilt), where nothing is in the way; W/m2.
struct SkyLight {
    double isotropic = 0;   ///< evenly over the whole sky
    double around_sun = 0;  ///< from the sun's direction, on a surface that faces it
    double horizon = 0;     ///< from the horizon; may be negative, where it is dark
};

/// All of the light is even.
[[nodiscard]] SkyLight isotropic_light(const Irradiance& light) noexcept;

/// Ref: Perez, Ineichen, Seals, Michalsky, Stewart, "Modeling daylight availability and irradiance
/// components from direct and global irradiance", 1990 (table 6: irradiance, all sites).
/// @param altitude_deg of the sun, above 0
[[nodiscard]] SkyLight perez_light(const Irradiance& light, double altitude_deg,
                                   double extraterrestrial_w_m2) noexcept;

}  // namespace terravox::solar
