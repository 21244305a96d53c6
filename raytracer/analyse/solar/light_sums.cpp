#include "raytracer/analyse/solar/light_sums.hpp"

#include <optional>
#include <string_view>
#include <utility>

#include "common/geo/time_zone.hpp"
#include "common/util/error.hpp"
#include "common/util/numbers.hpp"
#include "raytracer/core/sky/sun.hpp"

namespace terravox::solar {
namespace {

std::optional<double> measure_share(std::string_view text) noexcept {
    const auto value = util::parse_number<double>(text);
    return value && *value >= 0 && *value <= 1 ? value : std::nullopt;
}

}  // namespace

CrownLight::CrownLight(const std::string& text, const geo::LatLon& place)
    : m_is_south(place.lat_deg < 0) {
    const std::string_view all = text;
    const std::size_t comma = all.find(',');
    const std::optional<double> with = measure_share(all.substr(0, comma));
    const std::optional<double> without =
        comma == std::string_view::npos ? with : measure_share(all.substr(comma + 1));
    if (!with || !without)
        throw util::UsageError("light the sky: analysis.crown_light = '" + text +
                               "'; allowed: a share of 0 to 1, or two separated by a comma, with "
                               "leaves and without them");
    m_with_leaves = *with;
    m_without_leaves = *without;
}

double CrownLight::share(int month) const noexcept {
    constexpr int kApril = 4;
    constexpr int kOctober = 10;
    const bool has_leaves =
        m_is_south ? month >= kOctober || month <= kApril : kApril <= month && month <= kOctober;
    return has_leaves ? m_with_leaves : m_without_leaves;
}

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
    const SunBins::Place place = m_is_binned ? m_bins.find_place(light.to)
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
