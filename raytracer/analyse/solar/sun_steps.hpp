#pragma once

#include <cstdint>
#include <functional>

#include "common/geo/sun_position.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::solar {

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
[[nodiscard]] Period period_of(const scene::Scene& scene, const geo::MapPlace& place);

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

}  // namespace terravox::solar
