#include "raytracer/apps/commands/country/script_arguments.hpp"

#include <CLI/CLI.hpp>

#include <cmath>
#include <filesystem>
#include <system_error>

#include "common/util/atomic_file.hpp"
#include "common/util/beside_program.hpp"
#include "common/util/error.hpp"
#include "common/util/shell_words.hpp"
#include "raytracer/farm/cluster/array_job.hpp"

namespace terravox::commands {
namespace {

namespace fs = std::filesystem;
using cluster::ArrayJob;
using cluster::Command;

std::string exec_line(const Command& command, const std::string& more = "") {
    return util::shell_array("command", command) + "exec \"${command[@]}\"" + more + "\n";
}

/// What a task may take: what the sample took, and a share more, since land differs.
int memory_of(const country::Plan& plan) {
    constexpr double kMore = 1.25;
    constexpr double kLeast_mib = 512;
    return static_cast<int>(std::ceil(std::max(kLeast_mib, kMore * plan.estimate.memory_mib)));
}

}  // namespace

void ScriptArguments::add_to(CLI::App& command) {
    const char* group = "Tasks for a cluster";
    command
        .add_option("--slurm", slurm,
                    "write a script that submits all shards and the join to Slurm: bash FILE")
        ->type_name("FILE")
        ->group(group);
    command
        .add_option("--kubernetes", kubernetes,
                    "write an Indexed Job of all shards and a Job that joins them, for kubectl")
        ->type_name("FILE")
        ->group(group);
    command.add_option("--openjd", openjd, "write a job template of Open Job Description")
        ->type_name("FILE")
        ->group(group);
    command
        .add_option("--archive", archive,
                    "archive that the last job writes; default: the plan's name and .tvx")
        ->type_name("FILE")
        ->group(group);
    command.add_option("--nodes", nodes, "number of tasks that run at the same time")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str()
        ->group(group);
    command.add_option("--cpus-per-task", needs.cpus, "processors of each task")
        ->check(CLI::Range(1, 1024))
        ->capture_default_str()
        ->group(group);
    command
        .add_option("--memory-per-task", needs.memory_mib,
                    "memory that each task asks for, MiB; default: a quarter more than the sample "
                    "took")
        ->check(CLI::Range(256, 1 << 24))
        ->group(group);
    command
        .add_option("--program", program,
                    "terravox-raytracer, where the machines find it; default: this one, in pods "
                    "and OpenJD that of the PATH")
        ->group(group);
    command.add_option("--name", name, "of the job of Kubernetes or OpenJD")
        ->capture_default_str()
        ->group(group);
    command.add_option("--partition", needs.partition, "of Slurm; default: its own")->group(group);
    command.add_option("--time", needs.time, "limit of each job, as sbatch takes it: 4:00:00")
        ->group(group);
    command
        .add_option("--sbatch", needs.extra,
                    "further options for sbatch: \"--account=map --qos=low\"; may be given several "
                    "times")
        ->expected(1)
        ->take_all()
        ->allow_extra_args(false)
        ->group(group);
    command.add_option("--image", pods.image, "container image of pods, with terravox-raytracer")
        ->group(group);
    command
        .add_option("--claim", pods.claim,
                    "persistent volume claim of pods, with data and plan (ReadWriteMany)")
        ->group(group);
    command
        .add_option("--mount", pods.mount,
                    "where it is in the pods; relative paths begin there, so the plan and its data "
                    "must be named by such")
        ->capture_default_str()
        ->group(group);
}

void ScriptArguments::check() const {
    needs.check();
    if (!kubernetes.empty())
        pods.check(name);
    for (const std::string& file : {slurm, kubernetes, openjd})
        if (!file.empty())
            util::check_writable(file);
}

void ScriptArguments::write(const country::PlanFolder& folder, const country::Plan& plan,
                            const std::string& given) const {
    if (slurm.empty() && kubernetes.empty() && openjd.empty())
        return;
    const auto job_of = [&](const std::string& runs, const std::string& at,
                            const std::string& out) {
        const Command base{runs, "country", "run", at};
        Command task = base;
        task.insert(task.end(), {"--threads", std::to_string(needs.cpus), "--quiet"});
        Command join = base;
        join.insert(join.end(), {"-o", out, "--join", "--quiet"});
        Command waiting = join;
        waiting.emplace_back("--wait");
        ArrayJob job;
        job.name = name;
        job.tasks_name = "shards";
        job.join_name = "join";
        job.tasks = static_cast<int>(plan.shards.size());
        job.task_body = [task](const std::string& number) {
            return "task=" + number + "\n" + exec_line(task, " --task \"$((task + 1))\"");
        };
        job.join_body = exec_line(join);
        job.waiting_join_body = exec_line(waiting);
        job.cpus = needs.cpus;
        job.memory_mib = needs.memory_mib > 0 ? needs.memory_mib : memory_of(plan);
        job.join_cpus = needs.cpus;
        job.join_memory_mib = job.memory_mib;
        return job;
    };
    const std::string out =
        archive.empty() ? (fs::path(given) / "").parent_path().string() + ".tvx" : archive;
    const std::string of_path = program.empty() ? "terravox-raytracer" : program;
    if (!slurm.empty()) {
        const fs::path here =
            program.empty() ? util::beside_program("terravox-raytracer") : fs::absolute(program);
        const ArrayJob job =
            job_of(here.string(), folder.path().string(), fs::absolute(out).string());
        cluster::JobPlace place{here, fs::current_path(), needs};
        place.needs.memory_mib = job.memory_mib;
        std::error_code failed;
        fs::create_directories(folder.path() / "logs", failed);
        if (failed)
            throw util::Error("make the folder " + (folder.path() / "logs").string() + ": " +
                              failed.message());
        util::write_file_atomically(folder.path() / "shards.sbatch",
                                    cluster::array_tasks_script(place, job));
        util::write_file_atomically(folder.path() / "join.sbatch",
                                    cluster::array_join_script(place, job));
        util::write_file_atomically(slurm, cluster::submission_script(folder.path(), job, nodes));
    }
    if (!kubernetes.empty()) {
        cluster::PodPlace place = pods;
        place.nodes = nodes;
        util::write_file_atomically(kubernetes,
                                    cluster::kubernetes_array(job_of(of_path, given, out), place));
    }
    if (!openjd.empty()) {
        ArrayJob job = job_of(of_path, given, out);
        job.work = fs::current_path().string();
        util::write_file_atomically(openjd, cluster::openjd_array(job));
    }
}

}  // namespace terravox::commands
