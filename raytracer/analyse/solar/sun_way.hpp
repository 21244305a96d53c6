#pragma once

#include <array>
#include <vector>

#include "common/geo/lat_lon.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::solar {

/// A direction in which the sun is for some time.
struct SunDirection {
    core::Vec3 to;     ///< of unit length, y > 0; x to the map's east, z to its south
    double hours = 0;  ///< for which it stands
    /// Clock times of its begin and end on a single day, hours; of a period nothing.
    double begin_h = 0;
    double end_h = 0;
    std::array<float, 12> month_hours{};  ///< `hours` by the months of the year
};

/// Where the sun is during an analysis.
struct SunWay {
    std::vector<SunDirection> directions;
    int days = 0;
    double hours = 0;  ///< for which the sun is up: those of all directions
};

/// The sun's way of a scene's analysis: one instant, the steps of a day, or those of a period.
///
/// The many positions of a period are gathered into bins of analysis.bin_deg by hour angle and
/// declination, in which the sun's way through the sky is a strip that bins fill evenly; a bin's
/// direction is the mean of its positions. A pure function of its arguments on every machine.
/// @param place nullptr: unknown
/// @throws UsageError as period_of() and each_sun_step(); without a place; for more directions than
/// a cell may have rays
[[nodiscard]] SunWay sun_way_of(const scene::Scene& scene, const geo::MapPlace* place);

}  // namespace terravox::solar
