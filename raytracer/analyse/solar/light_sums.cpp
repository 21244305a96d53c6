#include "raytracer/analyse/solar/light_sums.hpp"

#include <utility>

#include "common/geo/time_zone.hpp"
#include "raytracer/analyse/solar/sky_light.hpp"
#include "raytracer/core/sky/sun.hpp"

namespace terravox::solar {
namespace {

constexpr double kWattsPerKilowatt = 1000;

}  // namespace

int day_number(const geo::DateTime& clock) noexcept {
    return static_cast<int>(geo::days_from_1970(clock.year, clock.month, clock.day) -
                            geo::days_from_1970(clock.year, 1, 1)) +
           1;
}

LightSums::LightSums(const scene::Scene& scene, const geo::MapPlace& place)
    : m_crowns(scene.analysis.crown_light, place),
      m_is_perez(scene.analysis.diffuse == "perez"),
      m_is_binned(scene.analysis.bin_deg > 0),
      m_bins(place, m_is_binned ? scene.analysis.bin_deg : 1) {}

void LightSums::add(const SunStep& step, const Irradiance& light, double shines_h) {
    const double altitude_deg = step.sun.altitude_deg;
    const SkyLight sky =
        m_is_perez ? perez_light(light, altitude_deg, extraterrestrial_w_m2(day_number(step.clock)))
                   : isotropic_light(light);
    const double kilohours = step.hours / kWattsPerKilowatt;
    add_even(sky.isotropic * kilohours, step.clock.month);
    m_energy.horizon += sky.horizon * kilohours;
    add({sky::Sun(step.sun, 0).direction(), light.beam * kilohours, sky.around_sun * kilohours,
         shines_h, m_crowns.share(step.clock.month)});
}

void LightSums::add_even(double kwh_m2, int month) noexcept {
    m_energy.isotropic += kwh_m2;
    m_energy.through_crowns += kwh_m2 * m_crowns.share(month);
}

void LightSums::add(const LightDirection& light) {
    // Without light there is no mean direction either.
    const double weight = light.beam + light.around_sun;
    if (weight <= 0)
        return;
    const SunBins::Place place = m_is_binned ? m_bins.place_of(light.to)
                                             : SunBins::Place{static_cast<int>(m_found.size()), 0};
    LightDirection& bin = m_found[place];
    bin.to = bin.to + light.to * weight;
    bin.beam += light.beam;
    bin.around_sun += light.around_sun;
    bin.hours += light.hours;
    bin.through_crowns += light.through_crowns * weight;
    check_directions(m_found.size());
}

Energy LightSums::take() {
    for (auto& [_, bin] : m_found) {
        bin.to = core::normalized(bin.to);
        bin.through_crowns /= bin.beam + bin.around_sun;
        m_energy.sun.push_back(bin);
    }
    if (m_energy.isotropic > 0)
        m_energy.through_crowns /= m_energy.isotropic;
    return std::move(m_energy);
}

}  // namespace terravox::solar
