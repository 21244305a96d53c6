#include "raytracer/solar/sun_steps.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/geo/time_zone.hpp"
#include "common/util/error.hpp"
#include "raytracer/sky/sun_of.hpp"

namespace terravox::solar {
namespace {

constexpr double kHour_s = 3600;
constexpr std::int64_t kDay_s = 86'400;
constexpr int kFirstYear = 1900;
constexpr int kLastYear = 2100;

/// A day that is named by a field of the scene.
struct NamedDay {
    std::string text;
    std::string field;
};

std::int64_t day_of(const NamedDay& day) {
    const geo::DateTime date = sky::date_of(day.text, day.field);
    if (date.year < kFirstYear || date.year > kLastYear)
        throw util::UsageError("place the sun: " + day.field + " = '" + day.text +
                               "'; allowed: years " + std::to_string(kFirstYear) + " to " +
                               std::to_string(kLastYear));
    return geo::days_from_1970(date.year, date.month, date.day);
}

/// The instant at which a day of a place begins.
/// @param day since 1970-01-01
std::int64_t midnight_s(std::int64_t day, const scene::Scene::Sun& sun, const geo::LatLon& place) {
    const std::int64_t local_s = day * kDay_s;
    geo::DateTime clock = geo::clock_at(local_s, 0);
    if (sun.utc_offset_h)
        clock.utc_offset_h = *sun.utc_offset_h;
    else
        clock.utc_offset_h = sun.zone.empty() ? geo::solar_zone_offset_h(place.lon_deg)
                                              : geo::zone_offset_h(sun.zone, clock);
    return local_s - std::llround(clock.utc_offset_h * kHour_s);
}

double offset_at_h(std::int64_t utc_s, const scene::Scene::Sun& sun, const geo::LatLon& place) {
    if (sun.utc_offset_h)
        return *sun.utc_offset_h;
    return sun.zone.empty() ? geo::solar_zone_offset_h(place.lon_deg)
                            : geo::zone_offset_at_h(sun.zone, utc_s);
}

}  // namespace

Period period_of(const scene::Scene& scene, const geo::LatLon& place) {
    const scene::Scene::Analysis& analysis = scene.analysis;
    if (analysis.from.empty() != analysis.to.empty())
        throw util::UsageError(std::string("place the sun: analysis.") +
                               (analysis.from.empty() ? "from" : "to") +
                               " is missing; give both, or none to use sun.date");
    const bool is_day = analysis.from.empty();
    const NamedDay first =
        is_day ? NamedDay{scene.sun.date, "sun.date"} : NamedDay{analysis.from, "analysis.from"};
    const NamedDay last = is_day ? first : NamedDay{analysis.to, "analysis.to"};
    const std::int64_t begin = day_of(first);
    const std::int64_t end = day_of(last) + 1;
    if (begin >= end)
        throw util::UsageError("place the sun: analysis.to = '" + last.text +
                               "'; allowed: a day that is not before analysis.from = '" +
                               first.text + "'");
    return {midnight_s(begin, scene.sun, place), midnight_s(end, scene.sun, place),
            static_cast<int>(end - begin)};
}

void each_sun_step(const scene::Scene& scene, const geo::LatLon& place,
                   const std::function<void(const SunStep&)>& visit) {
    constexpr std::int64_t kMaxSteps = 1'000'000;
    const Period period = period_of(scene, place);
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
        step.clock = geo::clock_at(step.middle_s, offset_at_h(step.middle_s, scene.sun, place));
        step.sun = geo::sun_position(step.clock, place);
        step.hours = (end_s - begin_s) / kHour_s;
        if (step.sun.altitude_deg > 0)
            visit(step);
    }
}

}  // namespace terravox::solar
