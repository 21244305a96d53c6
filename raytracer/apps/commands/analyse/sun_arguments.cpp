#include "raytracer/apps/commands/analyse/sun_arguments.hpp"

#include <algorithm>
#include <CLI/CLI.hpp>

#include "common/util/error.hpp"
#include "raytracer/apps/commands/analyse/time_arguments.hpp"

namespace terravox::commands {
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
        ClockTime first = times_of(args.times).front();
        first.date.clear();
        scene = scene_at(scene, first);
    } else if (!args.at.empty()) {
        scene.sun.time_h = hour_of("--at", args.at);
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
