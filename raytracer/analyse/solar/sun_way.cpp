#include "raytracer/analyse/solar/sun_way.hpp"

#include <map>
#include <string>

#include "common/util/error.hpp"
#include "raytracer/analyse/solar/sun_bins.hpp"
#include "raytracer/analyse/solar/sun_steps.hpp"
#include "raytracer/core/sky/sun.hpp"
#include "raytracer/core/sky/sun_of.hpp"

namespace terravox::solar {
namespace {

core::Vec3 direction_of(const geo::SunPosition& sun) {
    return sky::Sun(sun, 0).direction();
}

SunDirection of_step(const SunStep& step) {
    SunDirection out;
    out.to = direction_of(step.sun);
    out.hours = step.hours;
    out.begin_h = step.clock.hour - step.hours / 2;
    out.end_h = step.clock.hour + step.hours / 2;
    out.month_hours[static_cast<std::size_t>(step.clock.month - 1)] =
        static_cast<float>(step.hours);
    return out;
}

SunWay instant_of(const scene::Scene& scene, const geo::MapPlace& place) {
    SunWay out;
    const geo::SunPosition sun = sky::sun_of(scene.sun, &place, geo::SunPrecision::kAnalysis);
    if (sun.altitude_deg > 0)
        out.directions.push_back({.to = direction_of(sun)});
    return out;
}

std::vector<SunDirection> steps_of(const scene::Scene& scene, const geo::MapPlace& place) {
    std::vector<SunDirection> out;
    each_sun_step(scene, place, [&](const SunStep& step) {
        out.push_back(of_step(step));
        check_directions(out.size());
    });
    return out;
}

std::vector<SunDirection> bins_of(const scene::Scene& scene, const geo::MapPlace& place) {
    const SunBins bins(place, scene.analysis.bin_deg);
    std::map<SunBins::Place, SunDirection> found;
    each_sun_step(scene, place, [&](const SunStep& step) {
        const SunDirection one = of_step(step);
        SunDirection& bin = found[bins.place_of(one.to)];
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

SunWay sun_way_of(const scene::Scene& scene, const geo::MapPlace* place) {
    if (place == nullptr)
        throw util::UsageError(
            "place the sun: the world has no place on Earth; allowed: worlds "
            "with a CRS");
    const scene::Scene::Analysis& analysis = scene.analysis;
    if (analysis.kind == core::AnalysisKind::kShadow)
        return instant_of(scene, *place);
    const bool is_day =
        analysis.kind == core::AnalysisKind::kSun || analysis.kind == core::AnalysisKind::kSunView;
    if (is_day && !analysis.from.empty())
        throw util::UsageError(
            "place the sun: analysis.kind = " + std::string(core::word_of(analysis.kind)) +
            " is of one day, but analysis.from is given; allowed: sun-period, sun-months");
    SunWay out;
    out.directions =
        is_day || analysis.bin_deg == 0 ? steps_of(scene, *place) : bins_of(scene, *place);
    out.days = period_of(scene, *place).days;
    for (const SunDirection& direction : out.directions)
        out.hours += direction.hours;
    return out;
}

}  // namespace terravox::solar
