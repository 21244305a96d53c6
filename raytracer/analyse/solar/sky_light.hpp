#pragma once

#include "raytracer/analyse/solar/clear_sky.hpp"

namespace terravox::solar {

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
