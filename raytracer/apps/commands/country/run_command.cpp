#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/thread/stop.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/files.hpp"
#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "raytracer/apps/commands/country/country_command.hpp"
#include "raytracer/farm/cluster/shard_runner.hpp"
#include "voxelserver/out/country/inputs.hpp"
#include "voxelserver/out/country/join.hpp"
#include "voxelserver/out/country/patch.hpp"
#include "voxelserver/out/country/status.hpp"
#include "voxelserver/out/country/task.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::commands {
namespace {

namespace fs = std::filesystem;
using country::PlanFolder;

struct RunArguments {
    std::string plan;
    std::string out;
    cluster::RunnerOptions runner;
    int task = 0;
    std::string scratch;
    int scratch_mib = 0;
    bool overwrite = false;
    bool join = false;
    bool wait = false;
    bool json = false;
    int memory_mib = 2048;  ///< of a patch, which runs alone
};

/// @return 3 where the archive lacks something
util::ExitCode say_missing(const country::Plan& plan, const country::JoinReport& report) {
    for (const country::MissingSquare& square : plan.missing)
        util::log_error("missing: {}: {}", util::printable(square.name),
                        util::printable(square.reason));
    for (const std::string& reason : report.reasons)
        util::log_error("{}", util::printable(reason));
    if (report.holes > 0)
        util::log_error("what was written has holes: {} boxes could not be made", report.holes);
    const bool is_whole = report.is_whole() && plan.missing.empty();
    return is_whole ? util::ExitCode::kDone : util::ExitCode::kHoles;
}

util::ExitCode run_task(const RunArguments& args, const PlanFolder& folder,
                        const country::Plan& plan) {
    if (!args.out.empty() || args.join)
        throw util::UsageError(
            "country run: --task with -o or --join; allowed: without them, a task makes a shard of "
            "the plan's folder");
    const thread::StopSignals signals;
    country::TaskOptions options;
    options.threads = args.runner.threads;
    options.scratch = args.scratch;
    options.scratch_bytes = static_cast<std::uint64_t>(args.scratch_mib) << 20;
    options.quiet = args.runner.quiet;
    options.stop = signals.token();
    const country::TaskOutcome outcome = country::make_shard(folder, plan, args.task, options);
    std::printf("shard %d of %zu: %s, %.1f MB\n", args.task, plan.shards.size(),
                outcome.made ? "made" : "there already",
                static_cast<double>(outcome.shard.bytes) / 1e6);
    country::JoinReport report;
    report.holes = outcome.holes.boxes;
    report.reasons = outcome.holes.reasons;
    report.damage = outcome.shard.damage.size();
    report.reasons.insert(report.reasons.end(), outcome.shard.damage.begin(),
                          outcome.shard.damage.end());
    return say_missing({}, report);
}

class CountryRun {
public:
    CountryRun(const RunArguments& args, const PlanFolder& folder, const country::Plan& plan)
        : m_args(args),
          m_folder(folder),
          m_plan(plan),
          m_out(fs::absolute(args.out).lexically_normal()) {}

    util::ExitCode run() {
        // While another one works, also for the check of the target.
        const auto lock = util::FileLock::try_take(m_folder.run_lock());
        if (!lock)
            throw util::Error(attempt() + util::FileLock::holder(m_folder.run_lock()) +
                              " runs it already");
        if (country::is_joined(m_folder, m_plan, m_out)) {
            std::printf("%s: there already, of %zu shards\n", m_args.out.c_str(),
                        m_plan.shards.size());
            return say_missing(m_plan, country::make_report(m_folder, m_plan));
        }
        country::check_current(m_plan, "run the plan " + m_folder.path().string());
        check_target();
        const thread::StopSignals signals;
        if (!m_args.join)
            cluster::make_all_shards(m_folder, m_plan, m_args.runner, signals.token());
        else
            wait_for_shards(signals.token());
        return join(signals.token());
    }

private:
    [[nodiscard]] std::string attempt() const {
        return "run the plan " + m_folder.path().string() + ": ";
    }

    void check_target() const {
        if (!m_args.overwrite && fs::exists(m_out))
            throw util::UsageError("write " + m_args.out +
                                   ": it is there already; allowed: another name, or --overwrite");
        util::check_writable(m_out);
        m_folder.make_folders();
        country::write_target(m_folder,
                              {m_plan.id(), m_out, country::state_of_file(m_out), "", ""});
    }

    void wait_for_shards(const std::stop_token& stop) const {
        constexpr std::chrono::seconds kPeriod{5};
        for (int number = 1; number <= static_cast<int>(m_plan.shards.size());) {
            if (country::finished_shard(m_folder, m_plan, number)) {
                ++number;
                continue;
            }
            if (!m_args.wait)
                throw util::Error(attempt() + "shard " + std::to_string(number) + " of " +
                                  std::to_string(m_plan.shards.size()) +
                                  " is missing; without --join, it is made");
            if (thread::wait_for_stop(stop, kPeriod))
                throw util::Error(attempt() + "interrupted");
        }
    }

    util::ExitCode join(const std::stop_token& stop) const {
        constexpr std::uint64_t kSteps = 1000;
        exports::Meter meter("join", kSteps, m_args.runner.quiet);
        const country::JoinReport report = country::join(
            m_folder, m_plan, m_out, m_args.join ? m_args.runner.threads : 0,
            [&](std::uint64_t bytes, std::uint64_t total) {
                if (stop.stop_requested())
                    throw util::Error(attempt() +
                                      "interrupted; all shards are there, the same command goes "
                                      "on");
                meter.reach(bytes, total);
            });
        meter.finish();
        std::printf("%s: %llu boxes, %llu holes, of %zu shards\n", m_args.out.c_str(),
                    static_cast<unsigned long long>(report.boxes),
                    static_cast<unsigned long long>(report.holes), m_plan.shards.size());
        return say_missing(m_plan, report);
    }

    const RunArguments& m_args;
    const PlanFolder& m_folder;
    const country::Plan& m_plan;
    const fs::path m_out;
};

util::ExitCode run_run(const RunArguments& args) {
    util::set_up_log(args.runner.quiet ? "warn" : "info");
    const PlanFolder folder{args.plan};
    const country::Plan plan = country::read_plan(folder);
    if (args.task != 0)
        return run_task(args, folder, plan);
    if (args.out.empty())
        throw util::UsageError("country run: no archive; allowed: -o OUT.tvx, or --task I");
    if (!args.scratch.empty() || args.scratch_mib > 0)
        throw util::UsageError(
            "country run: --scratch or --scratch-mib without --task; allowed: with it");
    if (args.wait && !args.join)
        throw util::UsageError("country run: --wait without --join; allowed: with it");
    return CountryRun(args, folder, plan).run();
}

util::ExitCode run_resume(RunArguments args) {
    const PlanFolder folder{args.plan};
    const auto target = country::read_target(folder);
    if (!target)
        throw util::UsageError("resume the plan " + args.plan +
                               ": no run has begun; allowed: terravox country run first, which "
                               "says where the archive goes");
    args.out = country::confirmed_archive(folder, *target, args.out, "resume the plan " + args.plan)
                   .string();
    // What was to be written over then may be so now.
    args.overwrite =
        !target->before.empty() && country::state_of_file(target->archive) == target->before;
    return run_run(args);
}

util::ExitCode run_status(const RunArguments& args) {
    util::set_up_log("error");
    const PlanFolder folder{args.plan};
    const country::Plan plan = country::read_plan(folder);
    const country::CountryStatus status = country::find_status(folder, plan);
    const std::string said =
        args.json ? country::to_json(status, plan) + "\n" : country::to_text(status, plan);
    std::fputs(said.c_str(), stdout);
    const bool lacks = status.holes() > 0 || !plan.missing.empty();
    return lacks ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

CLI::App* add_command(CLI::App& country, RunArguments& args, const char* name, const char* about) {
    CLI::App* const command = country.add_subcommand(name, about);
    command->add_option("plan", args.plan, "the plan's folder")->required();
    return command;
}

void add_machine_options(CLI::App& command, RunArguments& args) {
    command.add_option("--jobs", args.runner.jobs, "tasks at the same time; 0: one for each core")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    command
        .add_option("--threads", args.runner.threads,
                    "of each task; 0: the cores divided by the tasks")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    command.add_flag("-q,--quiet", args.runner.quiet, "no progress");
}

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

util::ExitCode run_patch(const RunArguments& args) {
    util::set_up_log(args.runner.quiet ? "warn" : "info");
    const country::PlanFolder folder{args.plan};
    const thread::StopSignals signals;
    country::PatchOptions options;
    options.archive = args.out;
    options.threads = args.runner.threads;
    options.memory_bytes = static_cast<std::size_t>(args.memory_mib) << 20;
    options.quiet = args.runner.quiet;
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

std::function<util::ExitCode()> add_country_runs(CLI::App& country) {
    auto args = std::make_shared<RunArguments>();
    CLI::App* const run =
        add_command(country, *args, "run",
                    "Make all shards of a plan that are not there, each by a process of its own, "
                    "and join them");
    run->add_option("-o,--output", args->out, "box archive (.tvx) to write");
    run->add_flag("--overwrite", args->overwrite, "write over what is there");
    run->add_flag("--join", args->join, "make no shard, join them only");
    run->add_flag("--wait", args->wait,
                  "with --join: wait until all shards are there, whoever makes them");
    run->add_option("--task", args->task,
                    "make only this shard, 1 to the number of shards: what a task of a cluster "
                    "does")
        ->check(CLI::PositiveNumber);
    run->add_option("--scratch", args->scratch,
                    "with --task: folder for decoded squares, which tasks of one machine may "
                    "share; default: one in the plan's folder that goes away with the task");
    run->add_option("--scratch-mib", args->scratch_mib,
                    "with --task: limit of that folder, MiB; default: the plan's")
        ->check(CLI::Range(64, 1 << 28));
    add_machine_options(*run, *args);
    CLI::App* const status =
        add_command(country, *args, "status",
                    "Say what is done, what runs and what failed, here and on other machines, and "
                    "how long it will take");
    status->add_flag("--json", args->json, "as JSON");
    CLI::App* const resume =
        add_command(country, *args, "resume",
                    "Go on with the last run of a plan: the same as `run` with the same -o");
    resume->add_option("-o,--output", args->out, country::kConfirmedArchive);
    add_machine_options(*resume, *args);
    CLI::App* const patch = add_command(
        country, *args, "patch",
        "Bring the finished archive of a plan up to date: squares that have changed, are new or "
        "are gone since");
    patch->add_option("-o,--output", args->out, country::kConfirmedArchive);
    patch->add_option("--threads", args->runner.threads, "0: one for each core")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    patch
        ->add_option("--memory-mib", args->memory_mib,
                     "limit of what is kept of the data in memory, MiB; what does not fit is "
                     "decoded more than once")
        ->check(CLI::Range(64, 1 << 20))
        ->capture_default_str();
    patch->add_flag("-q,--quiet", args->runner.quiet, "no progress");
    return [=] {
        if (run->parsed())
            return run_run(*args);
        if (resume->parsed())
            return run_resume(*args);
        return patch->parsed() ? run_patch(*args) : run_status(*args);
    };
}

}  // namespace terravox::commands
