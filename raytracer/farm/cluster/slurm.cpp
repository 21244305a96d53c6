#include "raytracer/farm/cluster/slurm.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <span>
#include <sstream>
#include <string_view>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/folders.hpp"
#include "raytracer/core/animate/video.hpp"

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
    const util::Finished done = util::run_to_end(command, folder);
    // "123" or "123;cluster"
    const JobId job = done.out.substr(0, done.out.find_first_of(";\n"));
    if (done.status != 0 || job.empty() || job.find_first_not_of("0123456789") != std::string::npos)
        throw util::Error("submit " + (folder / script).string() + ": " + done.reason());
    return job;
}

std::optional<Slurm::Counts> Slurm::counts(const std::vector<JobId>& jobs) const {
    const util::Finished done =
        util::run_to_end({"squeue", "--me", "--noheader", "--array", "--format=%F %K %t %r"});
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
            (void)util::run_to_end({"scontrol", "update",
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
        const util::Finished done = util::run_to_end(command);
        return done.status == 0 ? "" : done.reason();
    } catch (const std::exception& e) {
        return e.what();
    }
}

int Slurm::array_limit() const {
    const util::Finished done = util::run_to_end({"scontrol", "show", "config"});
    const auto limit = number_after(done.out, "\nMaxArraySize");
    if (done.status != 0 || !limit || *limit < 1)
        throw util::Error("query Slurm for MaxArraySize: " + done.reason());
    return *limit;
}

std::optional<int> Slurm::exit_code(const JobId& job) const {
    const util::Finished done = util::run_to_end({"scontrol", "--oneliner", "show", "job", job});
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

int QueueWatch::look() {
    const auto counts = m_slurm.counts(jobs);
    m_empty_looks = counts && counts->all() == 0 ? m_empty_looks + 1 : 0;
    if (counts && !m_quiet && counts != m_last) {
        m_last = counts;
        // Overwrites the bar that the render may be drawing; it draws a new one below.
        std::fprintf(stderr, "%sslurm: %d of %d tasks run, %d wait\n",
                     ::isatty(STDERR_FILENO) != 0 ? "\r\x1b[K" : "", counts->running, m_tasks,
                     counts->waiting);
    }
    return m_empty_looks;
}

namespace fs = std::filesystem;

JobFolder::JobFolder(const SlurmOptions& options, const std::string& picture)
    : m_path(fs::absolute(options.folder.empty() ? fs::path("jobs") / picture : options.folder)) {
    m_path = m_path.lexically_normal();
    if (!m_path.has_filename())
        m_path = m_path.parent_path();  // "a/" is "a"
    // Slurm reads % and \\ in the folder of a job as a pattern for the names of logs, and then
    // finds no logs/.
    if (m_path.string().find_first_of("%\\") != std::string::npos)
        throw util::UsageError(
            "cluster: the job's folder " + m_path.string() +
            "; allowed: a path without % and \\, which Slurm takes for patterns (--folder)");
    options.needs.check();
    m_place.work = fs::current_path();
    m_place.needs = options.needs;
    m_program = options.program.empty() ? util::beside_program("terravox-raytracer")
                                        : fs::absolute(options.program);
    std::error_code failed;
    fs::create_directories(m_path / "logs", failed);
    if (failed)
        throw util::Error("make the folder of the job " + m_path.string() + ": " +
                          failed.message());
}

void JobFolder::write_script(const std::string& file, SlurmJob job, const Body& body,
                             const std::string& name) const {
    util::write_file_atomically(m_path / (file + ".sbatch"),
                                slurm_script(m_place, name.empty() ? file : name, job, body));
}

void JobFolder::write_secret(const std::string& name, const std::string& text) const {
    const fs::path file = m_path / name;
    const auto fail = [&](int code) {
        throw util::Error("write " + file.string() + ": " + std::strerror(code));
    };
    if (::unlink(file.c_str()) != 0 && errno != ENOENT)
        fail(errno);
    // Never readable by others, not even for a moment.
    const int fd =
        util::open_to_write(file, O_WRONLY | O_CREAT | O_EXCL, 0600, "write " + file.string());
    const int code = util::write_all(fd, std::as_bytes(std::span(text)));
    if (::close(fd) != 0 || code != 0)
        fail(code != 0 ? code : errno);
}

}  // namespace terravox::cluster
