#include "raytracer/analyse/solar/sun_way.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "common/util/error.hpp"
#include "raytracer/analyse/solar/place_and_clock.hpp"
#include "raytracer/core/sky/sun.hpp"

namespace terravox::solar {
namespace {

constexpr double kDegree = det::kPi / 180;  ///< radians

}  // namespace

void check_directions(std::size_t count) {
    if (count > kMaxDirections)
        throw util::UsageError("place the sun: more than " + std::to_string(kMaxDirections) +
                               " directions; allowed: fewer days, longer steps, or a larger "
                               "analysis.bin_deg");
}

SunBins::SunBins(const geo::MapPlace& place, double bin_deg)
    : m_latitude(det::sin_cos(place.lat_deg * kDegree)),
      m_convergence(det::sin_cos(place.convergence_deg * kDegree)),
      m_bin_deg(bin_deg) {
    if (!(bin_deg >= kSmallest_deg))
        throw util::UsageError("place the sun: analysis.bin_deg = " + std::to_string(bin_deg) +
                               "; allowed: 0.1 to 15, or 0 for a ray for each position");
}

SunBins::Place SunBins::find_place(core::Vec3 to) const noexcept {
    // Hour angle and declination are of true north: the map's turn is taken back.
    const double east = to.x * m_convergence.cos - to.z * m_convergence.sin;
    const double south = to.z * m_convergence.cos + to.x * m_convergence.sin;
    // The pole is in the north, the equator's highest point in the south.
    const double pole = to.y * m_latitude.sin - south * m_latitude.cos;
    const double equator = to.y * m_latitude.cos + south * m_latitude.sin;
    const double declination_deg = det::asin(pole) / kDegree;
    const double hour_angle_deg = det::atan2(-east, equator) / kDegree;
    return {static_cast<int>(std::floor(hour_angle_deg / m_bin_deg)),
            static_cast<int>(std::floor(declination_deg / m_bin_deg))};
}

namespace {

Period period_between(const Days& days, const Clock& clock) {
    return {clock.midnight_s(days.begin), clock.midnight_s(days.end),
            static_cast<int>(days.end - days.begin)};
}

}  // namespace

Period find_period(const scene::Scene& scene, const geo::MapPlace& place) {
    return period_between(list_days(scene), Clock(scene, place));
}

void each_sun_step(const scene::Scene& scene, const geo::MapPlace& place,
                   const std::function<void(const SunStep&)>& visit) {
    constexpr std::int64_t kMaxSteps = 1'000'000;
    constexpr double kHour_s = 3600;
    const Clock clock(scene, place);
    const Period period = period_between(list_days(scene), clock);
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

namespace {

core::Vec3 to_direction(const geo::SunPosition& sun) {
    return sky::Sun(sun, 0).direction();
}

SunDirection of_step(const SunStep& step) {
    SunDirection out;
    out.to = to_direction(step.sun);
    out.hours = step.hours;
    out.begin_h = step.clock.hour - step.hours / 2;
    out.end_h = step.clock.hour + step.hours / 2;
    out.month_hours[static_cast<std::size_t>(step.clock.month - 1)] =
        static_cast<float>(step.hours);
    return out;
}

SunWay find_instant(const scene::Scene& scene, const geo::MapPlace& place) {
    SunWay out;
    const geo::SunPosition sun = sky::compute_sun(scene.sun, &place, geo::SunPrecision::kAnalysis);
    if (sun.altitude_deg > 0)
        out.directions.push_back({.to = to_direction(sun)});
    return out;
}

std::vector<SunDirection> make_steps(const scene::Scene& scene, const geo::MapPlace& place) {
    std::vector<SunDirection> out;
    each_sun_step(scene, place, [&](const SunStep& step) {
        out.push_back(of_step(step));
        check_directions(out.size());
    });
    return out;
}

std::vector<SunDirection> make_bins(const scene::Scene& scene, const geo::MapPlace& place) {
    const SunBins bins(place, scene.analysis.bin_deg);
    std::map<SunBins::Place, SunDirection> found;
    each_sun_step(scene, place, [&](const SunStep& step) {
        const SunDirection one = of_step(step);
        SunDirection& bin = found[bins.find_place(one.to)];
        check_directions(found.size());
        bin.to = bin.to + one.to * one.hours;
        bin.hours += one.hours;
        for (std::size_t m = 0; m < bin.month_hours.size(); ++m)
            bin.month_hours[m] += one.month_hours[m];
    });
    std::vector<SunDirection> out;
    out.reserve(found.size());
    for (auto& [_, bin] : found) {
        bin.to = core::normalized(bin.to);
        out.push_back(bin);
    }
    return out;
}

}  // namespace

SunWay make_sun_way(const scene::Scene& scene, const geo::MapPlace* place) {
    if (place == nullptr)
        throw util::UsageError(
            "place the sun: the world has no place on Earth; allowed: worlds "
            "with a CRS");
    const scene::Scene::Analysis& analysis = scene.analysis;
    if (analysis.kind == core::AnalysisKind::kShadow)
        return find_instant(scene, *place);
    const bool is_day =
        analysis.kind == core::AnalysisKind::kSun || analysis.kind == core::AnalysisKind::kSunView;
    if (is_day && !analysis.from.empty())
        throw util::UsageError(
            "place the sun: analysis.kind = " + std::string(core::to_word(analysis.kind)) +
            " is of one day, but analysis.from is given; allowed: sun-period, sun-months");
    SunWay out;
    out.directions =
        is_day || analysis.bin_deg == 0 ? make_steps(scene, *place) : make_bins(scene, *place);
    out.days = find_period(scene, *place).days;
    for (const SunDirection& direction : out.directions)
        out.hours += direction.hours;
    return out;
}

}  // namespace terravox::solar
