#include "raytracer/analyse/solar/weather_light.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "common/geo/time_zone.hpp"
#include "common/util/det_math.hpp"
#include "common/util/error.hpp"
#include "raytracer/analyse/solar/light_sums.hpp"

namespace terravox::solar {
namespace {

constexpr double kHour_s = 3600;
constexpr double kPerKilo = 1e-3;
constexpr double kSunshine_w_m2 = 120;

/// Gives the steps of each hour its light.
class HourSums {
public:
    HourSums(const scene::Scene& scene, const geo::MapPlace& place, const WeatherFile& weather)
        : m_weather(weather), m_sums(scene, place) {
        const Period period = period_of(scene, place);
        m_next = hour_at(static_cast<double>(period.begin_s) + kHour_s / 2);
        m_end = hour_at(static_cast<double>(period.end_s) + kHour_s / 2);
    }

    void add(const SunStep& step) {
        const std::int64_t hour = hour_at(static_cast<double>(step.middle_s));
        if (!m_steps.empty() && hour != m_hour)
            finish_hour();
        m_hour = hour;
        m_steps.push_back(step);
    }

    [[nodiscard]] WeatherLight take() {
        if (!m_steps.empty())
            finish_hour();
        finish_night(m_end);
        m_out.energy = m_sums.take();
        return m_out;
    }

private:
    /// Hours since 1970-01-01 00:00 by the file's clock.
    [[nodiscard]] std::int64_t hour_at(double utc_s) const noexcept {
        return static_cast<std::int64_t>(std::floor(utc_s / kHour_s + m_weather.offset_h));
    }

    void finish_night(std::int64_t end) {
        for (; m_next < end; ++m_next) {
            const WeatherHour& hour = m_weather.at(m_next);
            const geo::DateTime clock = geo::clock_at(m_next * std::int64_t{3600}, 0);
            m_sums.add_even(hour.diffuse * kPerKilo, clock.month);
            m_out.level += hour.diffuse * kPerKilo;
            m_out.global += hour.global * kPerKilo;
        }
    }

    void finish_hour() {
        finish_night(m_hour);
        m_next = m_hour + 1;
        const WeatherHour& hour = m_weather.at(m_hour);
        double hours = 0;
        for (const SunStep& step : m_steps)
            hours += step.hours;
        const Irradiance light{hour.beam / hours, hour.diffuse / hours};
        for (const SunStep& step : m_steps) {
            m_sums.add(step, light, light.beam >= kSunshine_w_m2 ? step.hours : 0);
            const double sine = det::sin(step.sun.altitude_deg * det::kPi / 180);
            m_out.level += (light.beam * sine + light.diffuse) * step.hours * kPerKilo;
        }
        m_out.global += hour.global * kPerKilo;
        m_steps.clear();
    }

    const WeatherFile& m_weather;
    LightSums m_sums;
    WeatherLight m_out;
    std::int64_t m_next = 0;  ///< first hour whose light is not yet added
    std::int64_t m_end = 0;
    std::int64_t m_hour = 0;       ///< of m_steps
    std::vector<SunStep> m_steps;  ///< with the sun up
};

}  // namespace

WeatherLight weather_light(const scene::Scene& scene, const geo::MapPlace& place,
                           const WeatherFile& weather) {
    const double steps = 60 / scene.analysis.step_min;
    if (steps != std::floor(steps))
        throw util::UsageError("sum up the light: steps of " +
                               std::to_string(scene.analysis.step_min) +
                               " minutes; allowed with a weather file: those that fill an hour, "
                               "such as 10, 30 and 60");
    HourSums sums(scene, place, weather);
    each_sun_step(scene, place, [&](const SunStep& step) { sums.add(step); });
    return sums.take();
}

}  // namespace terravox::solar
