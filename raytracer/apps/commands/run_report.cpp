#include "raytracer/apps/commands/run_report.hpp"

#include <CLI/CLI.hpp>

#include "common/util/log.hpp"
#include "common/voxel/log_damage.hpp"

namespace terravox::commands {

void add_verbosity_flags(CLI::App& command, Verbosity& args) {
    CLI::Option* const quiet = command.add_flag("-q,--quiet", args.quiet, "print errors only");
    command.add_flag("-v,--verbose", args.verbose, "print the time of each step and the memory")
        ->excludes(quiet);
}

util::ExitCode report_gaps(const render::RenderStatistics& statistics, const std::string& what) {
    if (!statistics.counts.holes.empty())
        util::log_error("the {} has holes: {} boxes could not be loaded", what,
                        statistics.counts.holes.size());
    if (statistics.counts.missing > 0)
        util::log_error("the {} lacks {} tiles: no processor was left to render them", what,
                        statistics.counts.missing);
    if (!statistics.damage.empty())
        voxel::log_damage(statistics.damage);
    return statistics.has_holes() ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

}  // namespace terravox::commands
