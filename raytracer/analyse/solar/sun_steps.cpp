#include "raytracer/analyse/solar/sun_steps.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/util/error.hpp"
#include "raytracer/analyse/solar/clock.hpp"

namespace terravox::solar {
namespace {

Period period_between(const Days& days, const Clock& clock) {
    return {clock.midnight_s(days.begin), clock.midnight_s(days.end),
            static_cast<int>(days.end - days.begin)};
}

}  // namespace

Period period_of(const scene::Scene& scene, const geo::MapPlace& place) {
    return period_between(days_of(scene), Clock(scene, place));
}

void each_sun_step(const scene::Scene& scene, const geo::MapPlace& place,
                   const std::function<void(const SunStep&)>& visit) {
    constexpr std::int64_t kMaxSteps = 1'000'000;
    constexpr double kHour_s = 3600;
    const Clock clock(scene, place);
    const Period period = period_between(days_of(scene), clock);
    const double step_s = scene.analysis.step_min * 60;
    const double length_s = static_cast<double>(period.end_s - period.begin_s);
    const auto steps = static_cast<std::int64_t>(std::ceil(length_s / step_s));
    if (steps > kMaxSteps)
        throw util::UsageError("place the sun: " + std::to_string(period.days) + " days have " +
                               std::to_string(steps) +
                               " steps of analysis.step_min; allowed: up to " +
                               std::to_string(kMaxSteps));
    for (std::int64_t i = 0; i < steps; ++i) {
        const double begin_s = static_cast<double>(i) * step_s;
        const double end_s = std::min(begin_s + step_s, length_s);
        SunStep step;
        step.middle_s = period.begin_s + std::llround((begin_s + end_s) / 2);
        step.clock = geo::clock_at(step.middle_s, clock.offset_h(step.middle_s));
        step.sun = geo::sun_on_map(step.clock, place, geo::SunPrecision::kAnalysis);
        step.hours = (end_s - begin_s) / kHour_s;
        if (step.sun.altitude_deg > 0)
            visit(step);
    }
}

}  // namespace terravox::solar
