#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "common/geo/lat_lon.hpp"
#include "common/geo/sun_position.hpp"
#include "common/util/det_math.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::solar {

/// Directions of an analysis: rays of a cell are bounded, whatever a scene asks for.
inline constexpr std::size_t kMaxDirections = 65'536;
/// @throws UsageError for more than kMaxDirections
void check_directions(std::size_t count);

/// Bins of equal angles by hour angle and declination, as seen from a latitude: the sun's way
/// through the sky is a strip of these coordinates at every latitude.
class SunBins {
public:
    static constexpr double kSmallest_deg = 0.1;

    /// @param bin_deg at least kSmallest_deg
    /// @throws UsageError for smaller bins
    SunBins(const geo::MapPlace& place, double bin_deg);

    /// Numbers of a bin; they order bins from the east to the west.
    using Place = std::pair<int, int>;
    /// @param to of unit length; x to the map's east, y up, z to its south
    [[nodiscard]] Place find_place(core::Vec3 to) const noexcept;

private:
    det::SinCos m_latitude;
    det::SinCos m_convergence;
    double m_bin_deg;
};

/// Days of a place's calendar, from the first midnight to the last, as instants.
struct Period {
    std::int64_t begin_s = 0;  ///< seconds since 1970-01-01 00:00 UTC
    std::int64_t end_s = 0;    ///< after the last day
    int days = 0;
};

/// The period of a scene's analysis: analysis.from to analysis.to, both included, else sun.date.
/// A day has 23 or 25 hours where clocks change.
/// @throws UsageError for what is no date of the years 1900 to 2100, one date without the other, an
/// end before the beginning, an unknown zone
[[nodiscard]] Period find_period(const scene::Scene& scene, const geo::MapPlace& place);

/// A step of time, in the middle of which the sun's centre is above the horizon.
struct SunStep {
    geo::SunPosition sun;       ///< in the middle of the step; azimuth from the map's north
    geo::DateTime clock;        ///< of the middle
    std::int64_t middle_s = 0;  ///< as Period
    double hours = 0;           ///< how long it takes; the last one of a period may be shorter
};

/// Visits a period's steps of analysis.step_min, in order. They follow each other without a gap,
/// whatever clocks do.
/// @throws UsageError also for more than a million of them
void each_sun_step(const scene::Scene& scene, const geo::MapPlace& place,
                   const std::function<void(const SunStep&)>& visit);

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
/// @throws UsageError as find_period() and each_sun_step(); without a place; for more directions
/// than a cell may have rays
[[nodiscard]] SunWay make_sun_way(const scene::Scene& scene, const geo::MapPlace* place);

}  // namespace terravox::solar
