#include "raytracer/apps/commands/analyse/time_arguments.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/geo/time_zone.hpp"
#include "common/util/error.hpp"
#include "raytracer/core/sky/sun_of.hpp"

namespace terravox::commands {
namespace {

constexpr const char* kOption = "--times";
constexpr std::size_t kDate = 10;  // characters of YYYY-MM-DD

ClockTime time_of(const std::string& text) {
    ClockTime out;
    std::string clock = text;
    if (text.size() > kDate && text[kDate] == 'T') {
        out.date = text.substr(0, kDate);
        (void)sky::date_of(out.date, kOption);
        clock = text.substr(kDate + 1);
    }
    out.hour = hour_of(kOption, clock);
    out.band = "sunlit_" + text;
    std::erase(out.band, ':');
    return out;
}

}  // namespace

double hour_of(const std::string& option, const std::string& text) {
    unsigned hour = 0;
    unsigned minute = 0;
    int end = 0;
    const bool is_time = text.find_first_not_of("0123456789:") == std::string::npos &&
                         std::sscanf(text.c_str(), "%2u:%2u%n", &hour, &minute, &end) == 2 &&
                         static_cast<std::size_t>(end) == text.size() && hour < 24 && minute < 60;
    if (!is_time)
        throw util::UsageError("analyse sun: " + option + " " + text +
                               "; allowed: HH:MM, 00:00 to 23:59, on the clock of --zone");
    return hour + minute / 60.0;
}

std::vector<ClockTime> times_of(const std::string& text) {
    std::vector<ClockTime> out;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        out.push_back(time_of(text.substr(begin, end - begin)));
        begin = end + 1;
        if (out.size() > kMaxTimes)
            throw util::UsageError("analyse sun: more than " + std::to_string(kMaxTimes) +
                                   " times in --times; allowed: up to " +
                                   std::to_string(kMaxTimes));
    }
    for (std::size_t i = 0; i < out.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (out[i].band == out[j].band)
                throw util::UsageError("analyse sun: --times has " + out[i].band.substr(7) +
                                       " twice; allowed: each time once");
    return out;
}

std::int64_t instant_of(const scene::Scene& scene, const geo::MapPlace& place) {
    constexpr std::int64_t kDay_s = 86'400;
    constexpr double kHour_s = 3600;
    const geo::DateTime time = sky::time_of(scene.sun, &place);
    return geo::days_from_1970(time.year, time.month, time.day) * kDay_s +
           std::llround((time.hour - time.utc_offset_h) * kHour_s);
}

scene::Scene scene_at(const scene::Scene& scene, const ClockTime& time) {
    scene::Scene out = scene;
    out.analysis.kind = core::AnalysisKind::kShadow;
    out.sun.altitude_deg = std::nullopt;
    out.sun.azimuth_deg = std::nullopt;
    out.sun.time_h = time.hour;
    if (!time.date.empty())
        out.sun.date = time.date;
    return out;
}

}  // namespace terravox::commands
