#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/geo/lat_lon.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::solar {

/// Light from a direction over a period, kWh/m2 on a surface that faces it.
struct LightDirection {
    core::Vec3 to;              ///< of unit length, y > 0
    double beam = 0;            ///< of the sun
    double around_sun = 0;      ///< of the sky near to the sun
    double hours = 0;           ///< for which the sun shines from there
    double through_crowns = 0;  ///< share of the light that crowns let through
};

/// The light of a period: that of directions, and what the sky adds evenly (solar/sky_light.hpp).
/// Of a whole period these are few numbers, so that a cell needs one ray for each direction.
/// Ref: Robinson & Stone, "Irradiation modelling made simple: the cumulative sky approach and its
/// applications", 2004.
struct Energy {
    std::vector<LightDirection> sun;
    std::vector<core::Vec3> sky;  ///< directions of equal solid angles over the upper half sphere
    double isotropic = 0;         ///< kWh/m2 on a level surface
    double horizon = 0;           ///< kWh/m2
    double through_crowns = 0;    ///< share of these two that crowns let through
};

/// Heights of sky directions below which they belong to the horizon, as sine.
inline constexpr double kHorizonSine = 0.15;

/// The light of a scene's analysis: analysis.light, or else that of a sky without clouds. A pure
/// function of its arguments on every machine.
/// @param place nullptr: unknown; needed without analysis.light
/// @param height_m of the place above the sea
/// @throws UsageError as make_sun_way() and parse_light(); for turbidities that are none
[[nodiscard]] Energy make_energy(const scene::Scene& scene, const geo::MapPlace* place,
                                 double height_m);

/// Directions of the sun that a text of light may hold; a year in bins of 3 degrees has 630.
inline constexpr std::size_t kMaxListedDirections = 4096;

/// Light as text:
/// "isotropic,horizon,through_crowns;x,y,z,beam,around_sun,hours,through_crowns;...", one entry for
/// each direction of the sun (LightDirection). About 40 kB for a year in bins of 3 degrees: numbers
/// have the digits of single precision.
/// @throws UsageError for more than kMaxListedDirections
[[nodiscard]] std::string to_text(const Energy& light);

/// Reads such a text. The directions of the sky are not in it.
/// @param text from a scene, which may be anybody's
/// @throws UsageError for another text, for numbers that no light has, for more than
/// kMaxListedDirections
[[nodiscard]] Energy parse_light(const std::string& text);

}  // namespace terravox::solar
