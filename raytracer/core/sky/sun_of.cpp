#include "raytracer/core/sky/sun_of.hpp"

#include <cstdio>
#include <string>

#include "common/geo/time_zone.hpp"
#include "common/util/error.hpp"

namespace terravox::sky {
namespace {

// Of worlds that are not georeferenced.
constexpr geo::MapPlace kDefaultPlace{46, 14};

geo::DateTime clock_of(const scene::Scene::Sun& sun) {
    geo::DateTime time = date_of(sun.date, "sun.date");
    if (!(sun.time_h >= 0 && sun.time_h <= 24))
        throw util::UsageError("place the sun: sun.time_h = " + std::to_string(sun.time_h) +
                               "; allowed: 0 to 24");
    time.hour = sun.time_h;
    return time;
}

}  // namespace

geo::DateTime date_of(const std::string& text, const std::string& field) {
    geo::DateTime time;
    int end = 0;
    if (std::sscanf(text.c_str(), "%4d-%2d-%2d%n", &time.year, &time.month, &time.day, &end) != 3 ||
        static_cast<std::size_t>(end) != text.size())
        throw util::UsageError("place the sun: " + field + " = '" + text +
                               "'; allowed: YYYY-MM-DD");
    if (!geo::is_date(time.year, time.month, time.day))
        throw util::UsageError("place the sun: " + field + " = '" + text +
                               "' is no day of the calendar");
    time.hour = 0;
    return time;
}

geo::DateTime time_of(const scene::Scene::Sun& sun, const geo::MapPlace* place) {
    geo::DateTime time = clock_of(sun);
    const geo::MapPlace here = place != nullptr ? *place : kDefaultPlace;
    if (sun.utc_offset_h)
        time.utc_offset_h = *sun.utc_offset_h;
    else
        time.utc_offset_h = sun.zone.empty() ? geo::solar_zone_offset_h(here.lon_deg)
                                             : geo::zone_offset_h(sun.zone, time);
    return time;
}

geo::SunPosition sun_of(const scene::Scene::Sun& sun, const geo::MapPlace* place,
                        geo::SunPrecision precision) {
    if (sun.altitude_deg.has_value() != sun.azimuth_deg.has_value())
        throw util::UsageError(std::string("place the sun: sun.") +
                               (sun.altitude_deg ? "azimuth_deg" : "altitude_deg") +
                               " is missing; give both, or none to use date and time");
    if (sun.altitude_deg)
        return {*sun.altitude_deg, *sun.azimuth_deg};
    return geo::sun_on_map(time_of(sun, place), place != nullptr ? *place : kDefaultPlace,
                           precision);
}

}  // namespace terravox::sky
