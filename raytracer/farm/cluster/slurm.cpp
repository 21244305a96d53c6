#include "raytracer/farm/cluster/slurm.hpp"

#include <algorithm>
#include <charconv>
#include <sstream>

#include "common/util/error.hpp"
#include "raytracer/core/animate/video.hpp"

namespace terravox::cluster {
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
        if (animate::find_program(name).empty())
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

}  // namespace terravox::cluster
