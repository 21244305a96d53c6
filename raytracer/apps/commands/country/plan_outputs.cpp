#include "raytracer/apps/commands/country/plan_outputs.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "raytracer/apps/commands/cluster/cluster_command.hpp"

namespace terravox::commands {
namespace {

using country::Measured;
using country::Plan;
using country::PlannedFile;
using country::PlannedShard;

constexpr double kMega = 1e6;
constexpr double kGiga = 1e9;
constexpr double kHour_s = 3600;

double add_up(const std::vector<PlannedFile>& files, std::uint64_t PlannedFile::* member) {
    double sum = 0;
    for (const PlannedFile& file : files)
        sum += static_cast<double>(file.*member);
    return sum;
}

std::string bytes_text(double bytes) {
    return bytes < kGiga ? fmt::format("{:.1f} MB", bytes / kMega)
                         : fmt::format("{:.1f} GB", bytes / kGiga);
}

std::string hours_text(const Measured& cpu_s) {
    constexpr double kMinute_s = 60;
    if (cpu_s.value < 2 * kMinute_s)
        return fmt::format("{:.1f} +- {:.1f} core-seconds", cpu_s.value, cpu_s.error);
    if (cpu_s.value < kHour_s)
        return fmt::format("{:.1f} +- {:.1f} core-minutes", cpu_s.value / kMinute_s,
                           cpu_s.error / kMinute_s);
    return fmt::format("{:.1f} +- {:.1f} core-hours", cpu_s.value / kHour_s, cpu_s.error / kHour_s);
}

std::uint64_t most_scratch(const Plan& plan) {
    std::uint64_t most = 0;
    for (const PlannedShard& shard : plan.shards)
        most = std::max(most, shard.scratch_bytes);
    return most;
}

}  // namespace

std::string to_text(const Plan& plan) {
    const auto row = [](std::string_view name, const std::string& text) {
        return fmt::format("{:<8} {}\n", name, text);
    };
    const auto km = [&](std::size_t axis) {
        return (plan.bounds.max[axis] - plan.bounds.min[axis]) * plan.voxel_m / 1000;
    };
    const auto [fewest, most] = std::minmax_element(
        plan.shards.begin(), plan.shards.end(),
        [](const PlannedShard& a, const PlannedShard& b) { return a.cpu_s < b.cpu_s; });
    const country::Estimate& e = plan.estimate;
    std::string out;
    out += row("place", fmt::format("{:.1f} x {:.1f} km in {}, voxels of {} m", km(0), km(2),
                                    util::printable(plan.crs), plan.voxel_m));
    out += row("squares", fmt::format("{}, {:.1f} M points, {}; {} missing", plan.squares.size(),
                                      add_up(plan.squares, &PlannedFile::points) / kMega,
                                      bytes_text(add_up(plan.squares, &PlannedFile::bytes)),
                                      plan.missing.size()));
    out += row("shards", fmt::format("{}, of {:.1f} to {:.1f} core-seconds", plan.shards.size(),
                                     fewest->cpu_s, most->cpu_s));
    out += row("time", hours_text(e.cpu_s) + " on a cluster, " + hours_text(e.one_machine_cpu_s) +
                           " on one machine, where tasks share decoded squares");
    out += row("memory", fmt::format("{:.0f} MiB a task", e.memory_mib));
    out += row("scratch", bytes_text(static_cast<double>(most_scratch(plan))) + " a task");
    out += row("output",
               fmt::format("{} +- {}, and as much for the shards", bytes_text(e.output_bytes.value),
                           bytes_text(e.output_bytes.error)));
    return out + row("sample", fmt::format("{} columns of boxes were made", e.sampled_columns));
}

std::string to_json(const Plan& plan, const std::string& folder) {
    using Json = nlohmann::ordered_json;
    const auto measured = [](const Measured& m) {
        return Json{{"value", m.value}, {"error", m.error}};
    };
    const country::Estimate& e = plan.estimate;
    Json out{{"plan", folder},
             {"id", plan.id()},
             {"crs", plan.crs},
             {"voxel_m", plan.voxel_m},
             {"bounds", {{"min", plan.bounds.min}, {"max", plan.bounds.max}}},
             {"squares", plan.squares.size()},
             {"points", add_up(plan.squares, &PlannedFile::points)},
             {"shards", plan.shards.size()},
             {"sampled_columns", e.sampled_columns},
             {"cpu_s", measured(e.cpu_s)},
             {"one_machine_cpu_s", measured(e.one_machine_cpu_s)},
             {"memory_mib", e.memory_mib},
             {"scratch_bytes", most_scratch(plan)},
             {"output_bytes", measured(e.output_bytes)},
             {"missing", Json::array()}};
    for (const country::MissingSquare& square : plan.missing)
        out["missing"].push_back({{"name", square.name}, {"reason", square.reason}});
    return out.dump(2, ' ', false, Json::error_handler_t::replace);
}

namespace {

namespace fs = std::filesystem;
using cluster::ArrayJob;
using cluster::Command;
using cluster::extend;

/// What a task may take: what the sample took, and a share more, since land differs.
int choose_memory(const country::Plan& plan) {
    constexpr double kMore = 1.25;
    constexpr double kLeast_mib = 512;
    return static_cast<int>(std::ceil(std::max(kLeast_mib, kMore * plan.estimate.memory_mib)));
}

ArrayJob make_job(const std::string& name, const Command& run, const std::string& out, int cpus,
                  int tasks, const cluster::Engine& engine) {
    const Command task = extend(run, {"--threads", std::to_string(cpus), "--quiet"});
    const Command join = extend(run, {"-o", out, "--join", "--quiet"});
    return {
        .name = name,
        .tasks_name = "shards",
        .join_name = "join",
        .tasks = tasks,
        .task = cluster::fill("scripts/shards.sh",
                              {{"command", task}, {"tasks", tasks}, {"task", engine.number()}}),
        .join = cluster::fill("scripts/join.sh", {{"command", join}, {"waits", engine.waits()}})};
}

}  // namespace

void ScriptArguments::add_to(CLI::App& command) {
    const std::string before = command.option_defaults()->get_group();
    command.option_defaults()->group("Tasks for a cluster");
    command
        .add_option("--slurm", slurm,
                    "write a script that submits all shards and the join to Slurm: bash FILE")
        ->type_name("FILE");
    command
        .add_option("--kubernetes", kubernetes,
                    "write an Indexed Job of all shards and a Job that joins them, for kubectl")
        ->type_name("FILE");
    command.add_option("--openjd", openjd, "write a job template of Open Job Description")
        ->type_name("FILE");
    command
        .add_option("--archive", archive,
                    "archive that the last job writes; default: the plan's name and .tvx")
        ->type_name("FILE");
    command.add_option("--nodes", place.nodes, "number of tasks that run at the same time")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    command.add_option("--cpus-per-task", place.needs.cpus, "processors of each task")
        ->check(CLI::Range(1, 1024))
        ->capture_default_str();
    command
        .add_option("--memory-per-task", place.needs.memory_mib,
                    "memory that each task asks for, MiB; default: a quarter more than the sample "
                    "took")
        ->check(CLI::Range(256, 1 << 24));
    command.add_option("--program", program,
                       "terravox-raytracer, where the machines find it; default: this one, in pods "
                       "and OpenJD that of the PATH");
    command.add_option("--name", name, "of the job of Kubernetes or OpenJD")->capture_default_str();
    add_sbatch_options(command, place.needs);
    add_pod_options(command, place.pods);
    command.option_defaults()->group(before);
}

void ScriptArguments::check() const {
    place.needs.check();
    if (!kubernetes.empty())
        place.pods.check(name);
    for (const std::string& file : {slurm, kubernetes, openjd})
        if (!file.empty())
            util::check_writable(file);
}

void ScriptArguments::write(const country::PlanFolder& folder, const country::Plan& plan,
                            const std::string& given) const {
    const std::string out =
        archive.empty() ? (fs::path(given) / "").parent_path().string() + ".tvx" : archive;
    cluster::Place here = place;
    here.work = fs::current_path();
    here.folder = folder.path();
    if (here.needs.memory_mib == 0)
        here.needs.memory_mib = choose_memory(plan);
    const int shards = static_cast<int>(plan.shards.size());
    const std::array<std::string, cluster::kEngines.size()> files{slurm, openjd, kubernetes};
    for (std::size_t i = 0; i < files.size(); ++i) {
        if (files[i].empty())
            continue;
        const cluster::Engine& engine = cluster::kEngines[i];
        const Command run{engine.find_program(program), "country", "run",
                          engine.runs_here ? folder.path().string() : given};
        const std::string target = engine.runs_here ? fs::absolute(out).string() : out;
        const cluster::JobFiles made =
            engine.make_array(make_job(name, run, target, here.needs.cpus, shards, engine), here);
        made.write_scripts(folder.path());
        util::write_file_atomically(files[i], made.start);
    }
}

}  // namespace terravox::commands
