#include "raytracer/solar/energy.hpp"

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "common/geo/time_zone.hpp"
#include "common/util/det_math.hpp"
#include "common/util/error.hpp"
#include "raytracer/sky/sun.hpp"
#include "raytracer/solar/clear_sky.hpp"
#include "raytracer/solar/sky_light.hpp"
#include "raytracer/solar/sun_bins.hpp"
#include "raytracer/solar/sun_steps.hpp"

namespace terravox::solar {
namespace {

constexpr double kWattsPerKilowatt = 1000;

/// Points of a spiral: each has the same height of the half sphere, and so the same solid angle.
std::vector<core::Vec3> sky_directions(int count) {
    constexpr double kGoldenAngle = 2.39996322972865332;
    std::vector<core::Vec3> out;
    out.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        const double y = (i + 0.5) / count;
        const det::SinCos azimuth = det::sin_cos(i * kGoldenAngle);
        const double level = std::sqrt(1 - y * y);
        out.push_back({level * azimuth.cos, y, level * azimuth.sin});
    }
    return out;
}

int day_number(const geo::DateTime& clock) {
    return static_cast<int>(geo::days_from_1970(clock.year, clock.month, clock.day) -
                            geo::days_from_1970(clock.year, 1, 1)) +
           1;
}

/// Adds up the light of the steps of a period.
class LightSums {
public:
    LightSums(const scene::Scene& scene, const geo::LatLon& place, double height_m)
        : m_linke(linke_of(scene.analysis.linke)),
          m_height_m(height_m),
          m_is_perez(scene.analysis.diffuse == "perez"),
          m_is_binned(scene.analysis.bin_deg > 0),
          m_bins(place.lat_deg, m_is_binned ? scene.analysis.bin_deg : 1) {}

    void add(const SunStep& step) {
        const int day = day_number(step.clock);
        const double altitude_deg = step.sun.altitude_deg;
        const Irradiance light = clear_sky(
            altitude_deg, m_linke[static_cast<std::size_t>(step.clock.month - 1)], m_height_m, day);
        const SkyLight sky = m_is_perez
                                 ? perez_light(light, altitude_deg, extraterrestrial_w_m2(day))
                                 : isotropic_light(light);
        const double kilohours = step.hours / kWattsPerKilowatt;
        m_energy.isotropic += sky.isotropic * kilohours;
        m_energy.horizon += sky.horizon * kilohours;
        add({sky::Sun(step.sun, 0).direction(), light.beam * kilohours, sky.around_sun * kilohours,
             step.hours});
    }
    [[nodiscard]] Energy take() {
        for (auto& [_, bin] : m_found) {
            bin.to = core::normalized(bin.to);
            m_energy.sun.push_back(bin);
        }
        return std::move(m_energy);
    }

private:
    void add(const LightDirection& light) {
        // Without light there is no mean direction either.
        const double weight = light.beam + light.around_sun;
        if (weight <= 0)
            return;
        const SunBins::Place place = m_is_binned
                                         ? m_bins.place_of(light.to)
                                         : SunBins::Place{static_cast<int>(m_found.size()), 0};
        LightDirection& bin = m_found[place];
        bin.to = bin.to + light.to * weight;
        bin.beam += light.beam;
        bin.around_sun += light.around_sun;
        bin.hours += light.hours;
        check_directions(m_found.size());
    }

    const std::array<double, 12> m_linke;
    const double m_height_m;
    const bool m_is_perez;
    const bool m_is_binned;
    const SunBins m_bins;
    std::map<SunBins::Place, LightDirection> m_found;
    Energy m_energy;
};

}  // namespace

Energy energy_of(const scene::Scene& scene, const geo::LatLon* place, double height_m) {
    if (place == nullptr)
        throw util::UsageError(
            "light the sky: the world has no place on Earth; allowed: worlds "
            "with a CRS");
    LightSums sums(scene, *place, height_m);
    each_sun_step(scene, *place, [&](const SunStep& step) { sums.add(step); });
    Energy out = sums.take();
    out.sky = sky_directions(scene.analysis.directions);
    return out;
}

}  // namespace terravox::solar
