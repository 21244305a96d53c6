#include "raytracer/apps/commands/analyse/sun_arguments.hpp"

#include <algorithm>
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "common/geo/time_zone.hpp"
#include "common/util/error.hpp"
#include "raytracer/analyse/horizon/horizon_maker.hpp"
#include "raytracer/core/sky/sun.hpp"

namespace terravox::commands {
namespace {

constexpr const char* kOption = "--times";
constexpr std::size_t kDate = 10;  // characters of YYYY-MM-DD

/// The hour of HH:MM.
/// @param option for the message @throws UsageError
double parse_hour(const std::string& option, const std::string& text) {
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

ClockTime to_time(const std::string& text) {
    ClockTime out;
    std::string clock = text;
    if (text.size() > kDate && text[kDate] == 'T') {
        out.date = text.substr(0, kDate);
        (void)sky::parse_date(out.date, kOption);
        clock = text.substr(kDate + 1);
    }
    out.hour = parse_hour(kOption, clock);
    out.band = "sunlit_" + text;
    std::erase(out.band, ':');
    return out;
}

}  // namespace

std::vector<ClockTime> parse_clock_times(const std::string& text) {
    std::vector<ClockTime> out;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        out.push_back(to_time(text.substr(begin, end - begin)));
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

std::int64_t find_instant(const scene::Scene& scene, const geo::MapPlace& place) {
    constexpr std::int64_t kDay_s = 86'400;
    constexpr double kHour_s = 3600;
    const geo::DateTime time = sky::to_time(scene.sun, &place);
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

namespace {

void refuse_together(const std::string& command, const std::string& one, const std::string& other) {
    throw util::UsageError("analyse " + command + ": " + one + " together with " + other +
                           "; allowed: one of them");
}

}  // namespace

void add_sun_options(CLI::App& command, SunArguments& args) {
    command.add_option("--at", args.at,
                       "clock time HH:MM on --date: whether the sun shines at this instant, "
                       "instead of hours");
    command.add_option(
        "--times", args.times,
        "several such instants, HH:MM or YYYY-MM-DDTHH:MM separated by commas, up "
        "to 96: a shadow mask for each, as the bands of one raster, or along the time of a "
        "netCDF file, OUT.nc");
    command.add_flag("--monthly", args.monthly,
                     "with --from and --to: a band of hours for each month of the year");
}

void refuse_day_and_period(const std::string& command, const WorldArguments& world,
                           const scene::Scene& scene) {
    const bool has_date = std::any_of(world.fields.begin(), world.fields.end(),
                                      [](const auto& field) { return field.first == "sun.date"; });
    if (has_date && (!scene.analysis.from.empty() || !scene.analysis.to.empty()))
        refuse_together(command, "--date", "--from and --to");
}

void choose_sun_kind(const SunArguments& args, const WorldArguments& world, scene::Scene& scene) {
    refuse_day_and_period("sun", world, scene);
    const bool has_period = !scene.analysis.from.empty() || !scene.analysis.to.empty();
    if (has_period && !args.at.empty())
        refuse_together("sun", "--at", "--from and --to");
    if (!args.times.empty() && (has_period || !args.at.empty()))
        refuse_together("sun", "--times", has_period ? "--from and --to" : "--at");
    if (args.monthly && !has_period)
        throw util::UsageError(
            "analyse sun: --monthly without --from and --to; allowed: with a "
            "period");
    if (!args.times.empty()) {
        // The date of the first one is not that of those that have none.
        ClockTime first = parse_clock_times(args.times).front();
        first.date.clear();
        scene = scene_at(scene, first);
    } else if (!args.at.empty()) {
        scene.sun.time_h = parse_hour("--at", args.at);
        scene.sun.altitude_deg = std::nullopt;
        scene.sun.azimuth_deg = std::nullopt;
        scene.analysis.kind = core::AnalysisKind::kShadow;
    } else if (has_period) {
        scene.analysis.kind =
            args.monthly ? core::AnalysisKind::kSunMonths : core::AnalysisKind::kSunPeriod;
    } else {
        scene.analysis.kind = core::AnalysisKind::kSun;
    }
}

void add_weather_option(CLI::App& command, std::string& file) {
    command.add_option("--weather", file,
                       "EPW file: light of a year's hours by its weather, instead of a sky without "
                       "clouds");
}

std::optional<solar::WeatherFile> read_weather(const std::string& file,
                                               const WorldArguments& world) {
    if (file.empty())
        return std::nullopt;
    const bool has_linke =
        std::any_of(world.fields.begin(), world.fields.end(),
                    [](const auto& field) { return field.first == "analysis.linke"; });
    if (has_linke)
        throw util::UsageError(
            "analyse energy: --weather together with --linke; allowed: one of them");
    return solar::read_weather(file);
}

void add_horizon_options(CLI::App& command, HorizonArguments& args) {
    command.add_option("--horizon", args.file,
                       "raster of heights around the data, in any CRS: hills outside of the data "
                       "hide sun and sky; default: the horizon is free there");
    command
        .add_option("--horizon-km", args.range_km,
                    "how far from the data --horizon is looked at, kilometres")
        ->check(CLI::Range(0.1, 400.0))
        ->capture_default_str();
}

void check_horizon_arguments(const HorizonArguments& args, const scene::Scene& scene) {
    if (!args.file.empty() && scene.analysis.range_m > 0)
        throw util::UsageError(
            "analyse: --horizon together with --range-m, which ends before it; allowed: one of "
            "them");
}

void use_horizon(const HorizonArguments& args, const voxel::WorldInfo& world, scene::Scene& scene) {
    constexpr double kMetresPerKm = 1000;
    if (!args.file.empty())
        analyse::look_at_horizon({args.file, args.range_km * kMetresPerKm}, world, scene);
}

}  // namespace terravox::commands
