#include "raytracer/solar/sun_way.hpp"

#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "common/util/det_math.hpp"
#include "common/util/error.hpp"
#include "raytracer/sky/sun.hpp"
#include "raytracer/sky/sun_of.hpp"
#include "raytracer/solar/sun_steps.hpp"

namespace terravox::solar {
namespace {

constexpr std::size_t kMaxDirections = 65'536;
constexpr double kRad = det::kPi / 180;

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

/// Hour angle and declination of directions, in bins.
class SunBins {
public:
    SunBins(double latitude_deg, double bin_deg)
        : m_latitude(det::sin_cos(latitude_deg * kRad)), m_bin_deg(bin_deg) {}

    void add(const SunStep& step) {
        const SunDirection one = of_step(step);
        SunDirection& bin = m_bins[place_of(one.to)];
        bin.to = bin.to + one.to * one.hours;
        bin.hours += one.hours;
        for (std::size_t m = 0; m < bin.month_hours.size(); ++m)
            bin.month_hours[m] += one.month_hours[m];
    }
    /// The bins in the order of hour angles, each with its mean direction.
    [[nodiscard]] std::vector<SunDirection> take() {
        std::vector<SunDirection> out;
        out.reserve(m_bins.size());
        for (auto& [place, bin] : m_bins) {
            bin.to = core::normalized(bin.to);
            out.push_back(bin);
        }
        return out;
    }

private:
    using Place = std::pair<int, int>;
    [[nodiscard]] Place place_of(core::Vec3 to) const noexcept {
        // z points south: the pole is in the north, the equator's highest point in the south.
        const double pole = to.y * m_latitude.sin - to.z * m_latitude.cos;
        const double south = to.y * m_latitude.cos + to.z * m_latitude.sin;
        const double declination_deg = det::asin(pole) / kRad;
        const double hour_angle_deg = det::atan2(-to.x, south) / kRad;
        return {static_cast<int>(std::floor(hour_angle_deg / m_bin_deg)),
                static_cast<int>(std::floor(declination_deg / m_bin_deg))};
    }
    const det::SinCos m_latitude;
    const double m_bin_deg;
    std::map<Place, SunDirection> m_bins;
};

SunWay instant_of(const scene::Scene& scene, const geo::LatLon& place) {
    SunWay out;
    const geo::SunPosition sun = sky::sun_of(scene.sun, &place);
    if (sun.altitude_deg > 0)
        out.directions.push_back({.to = direction_of(sun)});
    return out;
}

std::vector<SunDirection> steps_of(const scene::Scene& scene, const geo::LatLon& place) {
    std::vector<SunDirection> out;
    each_sun_step(scene, place, [&](const SunStep& step) {
        if (out.size() == kMaxDirections)
            throw util::UsageError("place the sun: more than " + std::to_string(kMaxDirections) +
                                   " steps of sun without bins; allowed: fewer days, longer "
                                   "steps, or analysis.bin_deg above 0");
        out.push_back(of_step(step));
    });
    return out;
}

std::vector<SunDirection> bins_of(const scene::Scene& scene, const geo::LatLon& place) {
    SunBins bins(place.lat_deg, scene.analysis.bin_deg);
    each_sun_step(scene, place, [&](const SunStep& step) { bins.add(step); });
    return bins.take();
}

}  // namespace

SunWay sun_way_of(const scene::Scene& scene, const geo::LatLon* place) {
    if (place == nullptr)
        throw util::UsageError(
            "place the sun: the world has no place on Earth; allowed: worlds "
            "with a CRS");
    const scene::Scene::Analysis& analysis = scene.analysis;
    if (analysis.kind == core::AnalysisKind::kShadow)
        return instant_of(scene, *place);
    const bool is_day = analysis.kind == core::AnalysisKind::kSun;
    if (is_day && !analysis.from.empty())
        throw util::UsageError(
            "place the sun: analysis.kind = sun is of one day, but analysis.from "
            "is given; allowed: sun-period, sun-months");
    SunWay out;
    out.directions =
        is_day || analysis.bin_deg == 0 ? steps_of(scene, *place) : bins_of(scene, *place);
    out.days = period_of(scene, *place).days;
    for (const SunDirection& direction : out.directions)
        out.hours += direction.hours;
    return out;
}

}  // namespace terravox::solar
