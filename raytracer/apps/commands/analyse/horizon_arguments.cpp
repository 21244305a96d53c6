#include "raytracer/apps/commands/analyse/horizon_arguments.hpp"

#include <CLI/CLI.hpp>

#include "common/util/error.hpp"
#include "raytracer/analyse/horizon/horizon_maker.hpp"

namespace terravox::commands {

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
