#pragma once

#include <map>
#include <string>

#include "common/geo/lat_lon.hpp"
#include "raytracer/analyse/solar/energy.hpp"
#include "raytracer/analyse/solar/sky_light.hpp"
#include "raytracer/analyse/solar/sun_way.hpp"

namespace terravox::solar {

/// Share of light that a crown lets through, by the month: trees have leaves from April to October,
/// south of the equator from October to April.
class CrownLight {
public:
    /// @param text with leaves, and without: "0.03,0.45"; one number for both
    /// @throws UsageError unless each is 0 to 1
    CrownLight(const std::string& text, const geo::LatLon& place);

    /// @param month 1 to 12
    [[nodiscard]] double share(int month) const noexcept;

private:
    double m_with_leaves = 0;
    double m_without_leaves = 0;
    bool m_is_south = false;
};

/// Day of the year of a clock time, from 1.
[[nodiscard]] int day_number(const geo::DateTime& clock) noexcept;

/// Adds up the light of the steps of a period, by the bins of a scene's analysis.
class LightSums {
public:
    /// @throws UsageError as SunBins and CrownLight
    LightSums(const scene::Scene& scene, const geo::MapPlace& place);

    /// Adds the light of a step.
    /// @param shines_h hours of it that count as sunshine
    /// @throws UsageError as check_directions()
    void add(const SunStep& step, const Irradiance& light, double shines_h);
    /// Adds light of the sky that comes evenly, kWh/m2 on a level surface.
    /// @param month 1 to 12
    void add_even(double kwh_m2, int month) noexcept;
    /// The sums, without the directions of the sky.
    [[nodiscard]] Energy take();

private:
    void add(const LightDirection& light);

    const CrownLight m_crowns;
    const bool m_is_perez;
    const bool m_is_binned;
    const SunBins m_bins;
    std::map<SunBins::Place, LightDirection> m_found;
    Energy m_energy;
};

}  // namespace terravox::solar
