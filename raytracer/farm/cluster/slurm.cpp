#include "raytracer/farm/cluster/slurm.hpp"

#include <algorithm>
#include <charconv>
#include <numeric>
#include <sstream>
#include <string_view>

#include "common/util/error.hpp"
#include "common/util/process.hpp"
#include "common/util/text.hpp"
#include "raytracer/farm/cluster/tasks.hpp"

namespace terravox::cluster {

using util::Finished;
using util::run_to_end;

namespace {

/// The number after `key` in the output of scontrol, such as "MaxArraySize = 1001".
std::optional<int> number_after(const std::string& text, const std::string& key) {
    const std::size_t at = text.find(key);
    if (at == std::string::npos)
        return std::nullopt;
    const std::size_t begin = text.find_first_of("0123456789", at + key.size());
    if (begin == std::string::npos)
        return std::nullopt;
    int out = 0;
    if (std::from_chars(text.data() + begin, text.data() + text.size(), out).ec != std::errc{})
        return std::nullopt;
    return out;
}

}  // namespace

Slurm::Slurm() {
    for (const char* name : {"sbatch", "squeue", "scancel", "scontrol"})
        if (util::find_program(name).empty())
            throw util::Error(
                std::string("use Slurm: ") + name +
                " is not installed on this machine; submit from one that has Slurm, or "
                "look at --dry-run");
}

Slurm::JobId Slurm::submit(const std::filesystem::path& folder, const std::string& script,
                           const std::vector<std::string>& options,
                           const std::vector<std::string>& arguments) const {
    Command command{"sbatch", "--parsable"};
    command.insert(command.end(), options.begin(), options.end());
    command.push_back(script);
    command.insert(command.end(), arguments.begin(), arguments.end());
    const Finished done = run_to_end(command, folder);
    // "123" or "123;cluster"
    const JobId job = done.out.substr(0, done.out.find_first_of(";\n"));
    if (done.status != 0 || job.empty() || job.find_first_not_of("0123456789") != std::string::npos)
        throw util::Error("submit " + (folder / script).string() + ": " + done.reason());
    return job;
}

std::optional<Slurm::Counts> Slurm::counts(const std::vector<JobId>& jobs) const {
    const Finished done =
        run_to_end({"squeue", "--me", "--noheader", "--array", "--format=%F %K %t %r"});
    if (done.status != 0)
        return std::nullopt;
    Counts out;
    std::istringstream lines(done.out);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string job;
        std::string task;
        std::string state;
        std::string reason;
        if (!(words >> job >> task >> state >> reason) ||
            std::find(jobs.begin(), jobs.end(), job) == jobs.end())
            continue;
        (state == "PD" ? out.waiting : out.running) += 1;
        // No job of this program requests a later start: this one was requeued.
        if (state == "PD" && reason == "BeginTime")
            (void)run_to_end({"scontrol", "update",
                              "JobId=" + (task == "N/A" ? job : job + "_" + task),
                              "StartTime=now"});
    }
    return out;
}

std::string Slurm::cancel(const std::vector<JobId>& jobs) const noexcept {
    try {
        if (jobs.empty())
            return {};
        Command command{"scancel", "--quiet"};
        command.insert(command.end(), jobs.begin(), jobs.end());
        const Finished done = run_to_end(command);
        return done.status == 0 ? "" : done.reason();
    } catch (const std::exception& e) {
        return e.what();
    }
}

int Slurm::array_limit() const {
    const Finished done = run_to_end({"scontrol", "show", "config"});
    const auto limit = number_after(done.out, "\nMaxArraySize");
    if (done.status != 0 || !limit || *limit < 1)
        throw util::Error("query Slurm for MaxArraySize: " + done.reason());
    return *limit;
}

std::optional<int> Slurm::exit_code(const JobId& job) const {
    const Finished done = run_to_end({"scontrol", "--oneliner", "show", "job", job});
    if (done.status != 0)
        return std::nullopt;
    for (const char* at_work : {"JobState=PENDING", "JobState=RUNNING", "JobState=COMPLETING",
                                "JobState=CONFIGURING", "JobState=SUSPENDED"})
        if (done.out.find(at_work) != std::string::npos)
            return std::nullopt;
    if (done.out.find("JobState=COMPLETED") != std::string::npos)
        return 0;
    // A job that was cancelled or lost its node may have an exit code of 0.
    return std::max(1, number_after(done.out, "ExitCode=").value_or(1));
}

namespace {

/// @param name of the job, and of its logs
/// @param array whether Slurm runs it as an array
/// @param again whether it is requeued when its node fails
std::string head(const JobPlace& place, const std::string& name, std::string_view what, bool array,
                 bool again = true) {
    const Needs& n = place.needs;
    std::string out = "#!/bin/bash\n# " + std::string(what) + "\n";
    const auto ask = [&](const std::string& line) { out += "#SBATCH " + line + "\n"; };
    ask("--job-name=terravox-" + name);
    ask("--output=logs/" + name + (array ? "-%A_%a.txt" : "-%j.txt"));
    ask("--open-mode=append");  // a task's output is kept when it is requeued
    ask(again ? "--requeue" : "--no-requeue");
    ask("--nodes=1 --ntasks=1");
    if (n.cpus > 0)
        ask("--cpus-per-task=" + std::to_string(n.cpus));
    else
        ask("--exclusive");
    if (n.memory_mib > 0)
        ask("--mem=" + std::to_string(n.memory_mib) + "M");
    else if (n.cpus == 0)
        ask("--mem=0");
    if (!n.partition.empty())
        ask("--partition=" + n.partition);
    if (!n.time.empty())
        ask("--time=" + n.time);
    for (const std::string& line : n.extra)
        ask(line);
    return out + "set -euo pipefail\ncd -- " + util::shell_word(place.work.string()) + "\n";
}

// Numbers of an array have a limit; where one array is not enough, each gets the number of its
// first task.
constexpr const char* kTask = "$((${1:-0} + SLURM_ARRAY_TASK_ID))";

}  // namespace

void Needs::check() const {
    const auto refuse = [](const std::string& flag, const std::string& value, const char* allowed) {
        throw util::UsageError("cluster: " + flag + " " + value + "; allowed: " + allowed);
    };
    const auto plain = [](const std::string& text) {
        return std::all_of(text.begin(), text.end(), [](char c) {
            return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                   std::string_view("_-:.,").find(c) != std::string_view::npos;
        });
    };
    if (!plain(partition))
        refuse("--partition", partition, "letters, digits, _ - : . ,");
    if (!plain(time))
        refuse("--time", time, "as sbatch takes it, such as 4:00:00");
    for (const std::string& line : extra)
        if (!line.starts_with('-') || std::any_of(line.begin(), line.end(), [](char c) {
                return static_cast<unsigned char>(c) < 0x20;
            }))
            refuse("--sbatch", util::comment_text(line),
                   "options of sbatch on one line, such as \"--account=film --qos=low\"");
}

std::string pool_script(const JobPlace& place, const PoolScript& pool) {
    std::string out = head(place, "worker",
                           "Workers for one picture: each task lends its node to the coordinator "
                           "until the array is cancelled.",
                           true);
    // When the picture is complete, or its coordinator has gone for good, the node is released
    // automatically.
    Command command{place.program.string(),  "worker", "--once", "--idle-s", "600", "--token-file",
                    pool.token_file.string()};
    if (place.needs.cpus > 0)
        command.insert(command.end(), {"--threads", std::to_string(place.needs.cpus)});
    // A quarter is reserved for everything except boxes: the program, tiles, and threads.
    if (place.needs.memory_mib > 0)
        command.insert(
            command.end(),
            {"--memory-mib", std::to_string(std::max(1, place.needs.memory_mib / 4 * 3))});
    if (!pool.address.empty()) {
        command.insert(command.end(), {"--join", pool.address});
        return out + util::shell_array("command", command) + "exec \"${command[@]}\"\n";
    }
    const std::string file = util::shell_word(pool.address_file.string());
    return out + util::shell_array("command", command) +
           "# The coordinator says where it is once its job runs.\n"
           "for ((waited_s = 0; waited_s < 300; ++waited_s)); do\n"
           "    [[ -s " +
           file +
           " ]] && break\n"
           "    sleep 1\n"
           "done\n"
           "read -r address < " +
           file +
           "\n"
           "exec \"${command[@]}\" --join \"$address\"\n";
}

std::string coordinator_script(const JobPlace& place, const Command& command,
                               const std::string& host, const std::filesystem::path& address_file) {
    const std::string file = util::shell_word(address_file.string());
    return head(place, "coordinator",
                "The coordinator: renders the picture with the workers that join it.", false,
                false) +
           util::shell_array("command", command) +
           "# The first port without a listener.\n"
           "port=$((20000 + SLURM_JOB_ID % 10000))\n"
           "while (exec 3<>\"/dev/tcp/127.0.0.1/$port\") 2>/dev/null; do port=$((port + 1)); done\n"
           "printf '%s:%s\\n' " +
           (host.empty() ? std::string("\"$HOSTNAME\"") : util::shell_word(host)) +
           " \"$port\" > " + file +
           ".part\n"
           "mv -- " +
           file + ".part " + file +
           "\n"
           "exec \"${command[@]}\" --listen \":$port\"\n";
}

std::string bake_script(const JobPlace& place, const std::string& passed, const Command& words,
                        int tasks) {
    const std::string of = std::to_string(tasks);
    return head(place, "bake",
                "Prepares LiDAR squares: task N of " + of + " takes the N-th and each " + of +
                    "th after it. What is prepared is left as it is.",
                true) +
           util::shell_array("words", words) + "exec " + util::shell_word(place.program.string()) +
           " cluster bake --for " + passed + " --part \"$((SLURM_ARRAY_TASK_ID + 1))/" + of +
           "\" \"${words[@]}\"\n";
}

std::string frames_script(const JobPlace& place, const Command& command, const TaskPlan& plan) {
    return head(place, "frames",
                "Renders frames " + std::to_string(plan.frames.first) + " to " +
                    std::to_string(plan.frames.last) + ", " + std::to_string(plan.per_task) +
                    " a task. Frames that are done are left as they are: a task may run twice.",
                true) +
           frames_body(command, plan, kTask);
}

std::string merge_frames_script(const JobPlace& place, const std::string& pattern,
                                util::IntRange frames, const Command& command) {
    return head(place, "merge",
                "Looks whether all frames are there" +
                    std::string(command.empty() ? "." : ", then makes the video."),
                false) +
           merge_frames_body(pattern, frames, command);
}

std::string parts_script(const JobPlace& place, const Command& command, int parts) {
    const std::string of = std::to_string(parts);
    return head(place, "parts",
                "Renders one picture in " + of +
                    " parts, a file of tiles for each. Tiles that are in such a file are not "
                    "rendered again.",
                true) +
           util::shell_array("command", command) + "task=" + kTask +
           "\nexec \"${command[@]}\" --resume --part \"$((task + 1))/" + of + "\"\n";
}

std::string merge_parts_script(const JobPlace& place, const Command& arguments, int parts,
                               const std::filesystem::path& picture) {
    const std::string of = std::to_string(parts);
    return head(place, "merge", "Joins the parts of the picture.", false) +
           util::shell_array("outputs", arguments) +
           "tiles=()\n"
           "for ((part = 1; part <= " +
           of +
           "; ++part)); do\n"
           "    tiles+=(" +
           util::shell_word(picture.string() + ".part-") + "\"$part\"-of-" + of +
           ".tiles)\n"
           "done\n"
           "exec " +
           util::shell_word(place.program.string()) + " merge \"${tiles[@]}\" \"${outputs[@]}\"\n";
}

std::string array_tasks_script(const JobPlace& place, const ArrayJob& job) {
    return head(place, job.tasks_name,
                "Task N of " + std::to_string(job.tasks) +
                    ", from 0 on. What is done is left as it is: a task may run twice.",
                true) +
           job.task_body(kTask);
}

std::string array_join_script(const JobPlace& place, const ArrayJob& job) {
    return head(place, job.join_name, "Joins what the tasks have made.", false) + job.join_body;
}

std::string submission_script(const std::filesystem::path& folder, const ArrayJob& job, int nodes) {
    constexpr int kArrayLimit = 1001;  // as Slurm comes
    std::vector<int> tasks(static_cast<std::size_t>(job.tasks));
    std::iota(tasks.begin(), tasks.end(), 0);
    std::string out =
        "#!/bin/bash\n"
        "# Submits all tasks to Slurm, and the job that joins them: bash THIS_FILE\n"
        "set -euo pipefail\n"
        "cd -- " +
        util::shell_word(folder.string()) +
        "\nsubmit() {\n"
        "    local job\n"
        "    job=$(sbatch --parsable \"$@\")\n"
        "    echo \"${job%%;*}\"\n"
        "}\n"
        "all=\n"
        "wait=()  # one array after another: the limit applies to all of them\n";
    for (const ArrayPiece& piece : array_pieces(tasks, kArrayLimit))
        out += "job=$(submit --array=" + array_text(piece.indices) + "%" + std::to_string(nodes) +
               " \"${wait[@]}\" " + job.tasks_name + ".sbatch " + std::to_string(piece.offset) +
               ")\n"
               "all=$all:$job\n"
               "wait=(--dependency=afterany:\"$job\")\n";
    return out +
           "# afterany: the join itself finds what is missing, and a hole is no failure.\n"
           "join=$(submit --dependency=afterany\"$all\" " +
           job.join_name +
           ".sbatch)\n"
           "echo \"submitted: tasks ${all#:}, join $join\"\n";
}

}  // namespace terravox::cluster
