#include "raytracer/analyse/solar/weather.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "common/geo/time_zone.hpp"
#include "common/util/det_math.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/log.hpp"
#include "common/util/numbers.hpp"
#include "common/util/text.hpp"
#include "raytracer/analyse/solar/light_sums.hpp"

namespace terravox::solar {
namespace {

constexpr std::size_t kMax_bytes = std::size_t{16} << 20;
constexpr int kHeaderLines = 8;
constexpr std::size_t kHoursOfDay = 24;
constexpr std::size_t kHoursOfYear = 365 * kHoursOfDay;
constexpr int kLeapYear = 2000;
constexpr int kPlainYear = 2001;

/// A time that is written on a line of the file: hours end at it.
struct Stamp {
    int month = 1;
    int day = 1;
    int hour = 1;  ///< 1 to 24
    friend bool operator==(const Stamp&, const Stamp&) = default;
};

Stamp make_stamp(std::size_t index, bool is_leap) {
    const int year = is_leap ? kLeapYear : kPlainYear;
    const auto days = static_cast<std::int64_t>(index / kHoursOfDay);
    const geo::DateTime at = geo::clock_at((geo::days_from_1970(year, 1, 1) + days) * 86'400, 0);
    return {at.month, at.day, static_cast<int>(index % kHoursOfDay) + 1};
}

std::string to_text(const Stamp& at) {
    return "month " + std::to_string(at.month) + ", day " + std::to_string(at.day) + ", hour " +
           std::to_string(at.hour);
}

/// Reads one file.
class EpwReader {
public:
    explicit EpwReader(const std::filesystem::path& file)
        : m_attempt("read the weather file " + file.string()),
          m_text(util::read_text(file, kMax_bytes, m_attempt)),
          m_rest(m_text) {}

    [[nodiscard]] WeatherFile read() {
        read_location();
        read_periods();
        while (next_line())
            if (!util::trimmed(m_line).empty() && m_line != kEndOfDos)
                read_hour();
        check_length();
        check_missing();
        return std::move(m_out);
    }

private:
    /// Columns of a line of the file.
    enum Column : std::size_t { kMonth = 1, kDay = 2, kHour = 3, kGlobal = 13, kBeam, kDiffuse };
    static constexpr std::size_t kColumns = kDiffuse + 1;
    static constexpr std::string_view kEndOfDos = "\x1a";  ///< behind some old files

    [[noreturn]] void fail(const std::string& what) const {
        throw util::Error(m_attempt + ": " + what);
    }
    [[noreturn]] void fail_here(const std::string& what) const {
        fail("line " + std::to_string(m_number) + ": " + what);
    }

    bool next_line() {
        if (m_rest.empty())
            return false;
        const std::size_t end = std::min(m_rest.find('\n'), m_rest.size());
        m_line = m_rest.substr(0, end);
        m_rest.remove_prefix(std::min(end + 1, m_rest.size()));
        ++m_number;
        m_fields = {};
        std::string_view line = m_line;
        for (m_count = 0; m_count < m_fields.size(); ++m_count) {
            const std::size_t comma = line.find(',');
            m_fields[m_count] = util::trimmed(line.substr(0, comma));
            if (comma == std::string_view::npos) {
                ++m_count;
                break;
            }
            line.remove_prefix(comma + 1);
        }
        return true;
    }

    [[nodiscard]] double number(std::size_t column, const char* what, double min,
                                double max) const {
        const std::string_view text = m_fields.at(column);
        std::string_view digits = text;
        (void)util::take(digits, '+');
        const auto value = util::parse_number<double>(digits);
        if (!value || !(*value >= min && *value <= max))
            fail_here(std::string(what) + " = '" + std::string(text) +
                      "'; allowed: " + std::to_string(static_cast<int>(min)) + " to " +
                      std::to_string(static_cast<int>(max)));
        return *value;
    }

    void read_location() {
        constexpr std::size_t kLatitude = 6;
        if (!next_line() || !util::equal_but_for_case(m_fields[0], "LOCATION"))
            fail("it does not begin with LOCATION; allowed: EPW, the weather files of EnergyPlus");
        m_out.name = m_fields[1];
        m_out.place.lat_deg = number(kLatitude, "latitude", -90, 90);
        m_out.place.lon_deg = number(kLatitude + 1, "longitude", -180, 180);
        m_out.offset_h = number(kLatitude + 2, "time zone", -14, 14);
    }

    void read_periods() {
        while (m_number < kHeaderLines)
            if (!next_line())
                fail("it ends in its header");
        if (!util::equal_but_for_case(m_fields[0], "DATA PERIODS"))
            fail_here("it is not DATA PERIODS");
        if (m_fields[1] != "1" || m_fields[2] != "1")
            fail_here("'" + std::string(m_fields[1]) + "' periods of '" + std::string(m_fields[2]) +
                      "' values an hour; allowed: 1 and 1");
    }

    void read_hour() {
        if (m_count < kColumns)
            fail_here(std::to_string(m_count) + " values; allowed: " + std::to_string(kColumns) +
                      " and more");
        const Stamp stamp = {static_cast<int>(number(kMonth, "month", 1, 12)),
                             static_cast<int>(number(kDay, "day", 1, 31)),
                             static_cast<int>(number(kHour, "hour", 1, 24))};
        const std::size_t index = m_out.hours.size();
        if (stamp == Stamp{2, 29, 1} && make_stamp(index, true) == stamp)
            m_is_leap = true;
        if (index >= kHoursOfYear + (m_is_leap ? kHoursOfDay : 0))
            fail_here("it goes on after the end of the year");
        const Stamp expected = make_stamp(index, m_is_leap);
        if (stamp != expected)
            fail_here(to_text(stamp) + "; allowed here: " + to_text(expected) +
                      ", one line for each hour of a year");
        m_out.hours.push_back({radiation(kGlobal), radiation(kBeam), radiation(kDiffuse)});
    }

    [[nodiscard]] double radiation(Column column) {
        // Stands for no value, as does what is above it.
        constexpr double kMissing = 9999;
        constexpr double kMax_wh = 2000;
        if (m_fields[column].empty()) {
            count_missing();
            return 0;
        }
        const double value = number(column, "radiation", 0, 1e6);
        if (value >= kMissing) {
            count_missing();
            return 0;
        }
        return number(column, "radiation", 0, kMax_wh);
    }

    void count_missing() {
        if (m_missing == 0) {
            m_first_missing = make_stamp(m_out.hours.size(), m_is_leap);
            m_first_line = m_number;
        }
        if (m_last_line != m_number)
            ++m_missing;
        m_last_line = m_number;
    }

    void check_length() const {
        const std::size_t expected = kHoursOfYear + (m_is_leap ? kHoursOfDay : 0);
        if (m_out.hours.size() != expected)
            fail(std::to_string(m_out.hours.size()) +
                 " hours; allowed: " + std::to_string(kHoursOfYear) + ", or " +
                 std::to_string(kHoursOfYear + kHoursOfDay) + " with a 29 February");
    }

    void check_missing() const {
        if (m_missing > 0)
            fail("radiation is missing (9999) in " + std::to_string(m_missing) +
                 " hours, the first one on line " + std::to_string(m_first_line) + " (" +
                 to_text(m_first_missing) + "); allowed: none");
    }

    const std::string m_attempt;
    const std::string m_text;
    std::string_view m_rest;
    std::string_view m_line;
    std::array<std::string_view, kColumns> m_fields{};
    std::size_t m_count = 0;  ///< of m_fields that the line has
    int m_number = 0;         ///< of the line, from 1
    bool m_is_leap = false;
    std::size_t m_missing = 0;
    int m_first_line = 0;
    int m_last_line = 0;
    Stamp m_first_missing;
    WeatherFile m_out;
};

}  // namespace

const WeatherHour& WeatherFile::at(std::int64_t hour_of_time) const {
    constexpr std::int64_t kHour_s = 3600;
    const geo::DateTime clock = geo::clock_at(hour_of_time * kHour_s, 0);
    const bool is_leap = hours.size() > kHoursOfYear;
    const bool has_day = is_leap || clock.month != 2 || clock.day != 29;
    const int year = is_leap ? kLeapYear : kPlainYear;
    const std::int64_t days = geo::days_from_1970(year, clock.month, has_day ? clock.day : 28) -
                              geo::days_from_1970(year, 1, 1);
    const auto hour = static_cast<std::size_t>(std::llround(clock.hour));
    return hours.at(static_cast<std::size_t>(days) * kHoursOfDay + hour);
}

WeatherFile read_weather(const std::filesystem::path& file) {
    return EpwReader(file).read();
}

namespace {

constexpr double kHour_s = 3600;
constexpr double kPerKilo = 1e-3;
constexpr double kSunshine_w_m2 = 120;

/// Gives the steps of each hour its light.
class HourSums {
public:
    HourSums(const scene::Scene& scene, const geo::MapPlace& place, const WeatherFile& weather)
        : m_weather(weather), m_sums(scene, place) {
        const Period period = find_period(scene, place);
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

namespace {

/// Along a great circle.
double distance_km(const geo::LatLon& a, const geo::LatLon& b) {
    constexpr double kRadian = det::kPi / 180;
    constexpr double kEarth_km = 6371;
    const double north = std::sin((b.lat_deg - a.lat_deg) * kRadian / 2);
    const double east = std::sin((b.lon_deg - a.lon_deg) * kRadian / 2);
    const double part =
        north * north + std::cos(a.lat_deg * kRadian) * std::cos(b.lat_deg * kRadian) * east * east;
    return 2 * kEarth_km * std::asin(std::sqrt(std::min(part, 1.0)));
}

}  // namespace

void use_weather(const WeatherFile& weather, const geo::MapPlace& place, scene::Scene& scene) {
    constexpr double kFar_km = 50;
    const double far_km = distance_km(weather.place, place);
    if (far_km > kFar_km)
        util::log_warn(
            "the weather is that of {}, {:.0f} km from the data; up to {:.0f} km is near",
            weather.name, far_km, kFar_km);
    const WeatherLight light = weather_light(scene, place, weather);
    constexpr double kTolerance = 0.1;
    if (std::abs(light.level - light.global) > kTolerance * light.global)
        util::log_warn(
            "light of the weather file does not fit the sun: direct and diffuse light are {:.1f} "
            "kWh/m2 on level ground, global light is {:.1f}; is its time zone right?",
            light.level, light.global);
    scene.analysis.light = to_text(light.energy);
}

}  // namespace terravox::solar
