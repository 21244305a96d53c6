#include "raytracer/commands/analyse/sun_arguments.hpp"

#include <algorithm>
#include <CLI/CLI.hpp>
#include <cstdio>

#include "common/util/error.hpp"

namespace terravox::commands {
namespace {

double hour_of(const std::string& text) {
    unsigned hour = 0;
    unsigned minute = 0;
    int end = 0;
    const bool is_time = text.find_first_not_of("0123456789:") == std::string::npos &&
                         std::sscanf(text.c_str(), "%2u:%2u%n", &hour, &minute, &end) == 2 &&
                         static_cast<std::size_t>(end) == text.size() && hour < 24 && minute < 60;
    if (!is_time)
        throw util::UsageError("analyse sun: --at " + text +
                               "; allowed: HH:MM, 00:00 to 23:59, on the clock of --zone");
    return hour + minute / 60.0;
}

void refuse_together(const std::string& command, const std::string& one, const std::string& other) {
    throw util::UsageError("analyse " + command + ": " + one + " together with " + other +
                           "; allowed: one of them");
}

}  // namespace

void add_sun_options(CLI::App& command, SunArguments& args) {
    command.add_option("--at", args.at,
                       "clock time HH:MM on --date: whether the sun shines at this instant, "
                       "instead of hours");
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
    if (args.monthly && !has_period)
        throw util::UsageError(
            "analyse sun: --monthly without --from and --to; allowed: with a "
            "period");
    if (!args.at.empty()) {
        scene.sun.time_h = hour_of(args.at);
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

}  // namespace terravox::commands
