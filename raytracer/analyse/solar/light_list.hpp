#pragma once

#include <cstddef>
#include <string>

#include "raytracer/analyse/solar/energy.hpp"

namespace terravox::solar {

/// Directions of the sun that a text of light may hold; a year in bins of 3 degrees has 630.
inline constexpr std::size_t kMaxListedDirections = 4096;

/// Light as text:
/// "isotropic,horizon,through_crowns;x,y,z,beam,around_sun,hours,through_crowns;...", one entry for
/// each direction of the sun (LightDirection). About 40 kB for a year in bins of 3 degrees: numbers
/// have the digits of single precision.
/// @throws UsageError for more than kMaxListedDirections
[[nodiscard]] std::string text_of(const Energy& light);

/// Reads such a text. The directions of the sky are not in it.
/// @param text from a scene, which may be anybody's
/// @throws UsageError for another text, for numbers that no light has, for more than
/// kMaxListedDirections
[[nodiscard]] Energy light_of(const std::string& text);

}  // namespace terravox::solar
