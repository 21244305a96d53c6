#include <CLI/CLI.hpp>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "common/thread/stop_signals.hpp"
#include "common/util/log.hpp"
#include "common/util/printable.hpp"
#include "raytracer/apps/commands/country/run_command.hpp"
#include "voxelserver/out/country/join.hpp"
#include "voxelserver/out/country/patch.hpp"

namespace terravox::commands {
namespace {

struct PatchArguments {
    std::string plan;
    std::string out;
    int threads = 0;
    int memory_mib = 2048;  ///< it runs alone
    bool quiet = false;
};

void print_changes(const std::vector<std::string>& changes) {
    constexpr std::size_t kMaxShown = 20;
    const std::size_t count = changes.size();
    for (std::size_t i = 0; i < count && i < kMaxShown; ++i)
        std::printf("%s\n", util::printable(changes[i]).c_str());
    if (count > kMaxShown)
        std::printf("... and %zu more\n", count - kMaxShown);
    // Seen at once, also by a program that reads them: making boxes takes a while.
    std::fflush(stdout);
}

util::ExitCode run_patch(const PatchArguments& args) {
    util::set_up_log(args.quiet ? "warn" : "info");
    const country::PlanFolder folder{args.plan};
    const thread::StopSignals signals;
    country::PatchOptions options;
    options.archive = args.out;
    options.threads = args.threads;
    options.memory_bytes = static_cast<std::size_t>(args.memory_mib) << 20;
    options.quiet = args.quiet;
    options.stop = signals.token();
    options.on_changes = print_changes;
    const country::PatchOutcome outcome = country::patch_country(folder, options);
    const std::string archive = util::printable(outcome.archive.string());
    if (outcome.changes.empty())
        std::printf("%s: no square has changed since the plan was made\n", archive.c_str());
    else
        std::printf(
            "%s: %zu %s; %llu columns of boxes replaced, %llu records new, %llu kept, "
            "%llu holes\n",
            archive.c_str(), outcome.changes.size(),
            outcome.changes.size() == 1 ? "square" : "squares",
            static_cast<unsigned long long>(outcome.report.columns),
            static_cast<unsigned long long>(outcome.report.made),
            static_cast<unsigned long long>(outcome.report.kept),
            static_cast<unsigned long long>(outcome.report.holes));
    for (const country::MissingSquare& square : outcome.missing)
        util::log_error("missing: {}: {}", util::printable(square.name),
                        util::printable(square.reason));
    for (const std::string& line : outcome.damage)
        util::log_error("{}", util::printable(line));
    const bool is_whole =
        outcome.missing.empty() && outcome.damage.empty() && outcome.report.holes == 0;
    return is_whole ? util::ExitCode::kDone : util::ExitCode::kHoles;
}

}  // namespace

std::function<util::ExitCode()> add_country_patch(CLI::App& country) {
    auto args = std::make_shared<PatchArguments>();
    CLI::App* const command = country.add_subcommand(
        "patch",
        "Bring the finished archive of a plan up to date: squares that have changed, are new or "
        "are gone since");
    command->add_option("plan", args->plan, "the plan's folder")->required();
    command->add_option("-o,--output", args->out, country::kConfirmedArchive);
    command->add_option("--threads", args->threads, "0: one for each core")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    command
        ->add_option("--memory-mib", args->memory_mib,
                     "limit of what is kept of the data in memory, MiB; what does not fit is "
                     "decoded more than once")
        ->check(CLI::Range(64, 1 << 20))
        ->capture_default_str();
    command->add_flag("-q,--quiet", args->quiet, "no progress");
    return [args] { return run_patch(*args); };
}

}  // namespace terravox::commands
