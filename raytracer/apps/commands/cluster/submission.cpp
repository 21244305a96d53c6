#include "raytracer/apps/commands/cluster/submission.hpp"

#include <cstdio>
#include <fstream>

#include "common/thread/stop_signals.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/shell_words.hpp"

namespace terravox::cluster {
Submission::Submission(const SlurmOptions& options, const JobFolder& folder, const Slurm* slurm)
    : m_options(options), m_folder(folder), m_slurm(slurm) {
    std::ifstream in(file());
    for (std::string name, job; in >> name >> job;)
        m_before.push_back(job);
}

void Submission::wait_for_earlier() {
    if (m_slurm == nullptr || m_before.empty())
        return;
    const auto counts = m_slurm->counts(m_before);
    if (!counts)
        throw util::Error(std::string(kBatchAttempt) +
                          "squeue has no answer; without it, it is unknown whether the jobs of " +
                          file().string() + " are at work");
    if (counts->all() == 0)
        return;
    if (!m_options.wait)
        throw util::Error(std::string(kBatchAttempt) + std::to_string(counts->all()) +
                          " tasks of " + file().string() +
                          " are at work; wait for them, or scancel them");
    if (!m_options.quiet)
        std::fprintf(stderr, "slurm: %d tasks of an earlier call are at work\n", counts->all());
    follow(m_before, counts->all());
}

Slurm::JobId Submission::submit(const std::string& name, const std::vector<std::string>& options,
                                int tasks, const std::vector<std::string>& arguments) {
    m_tasks += tasks;
    if (m_slurm == nullptr) {
        if (m_tasks == tasks)
            std::printf("cd %s\n", util::shell_word(m_folder.path().string()).c_str());
        std::printf("sbatch");
        for (const std::string& option : options)
            std::printf(" %s", option.c_str());
        std::printf(" %s.sbatch", name.c_str());
        for (const std::string& argument : arguments)
            std::printf(" %s", argument.c_str());
        std::printf("\n");
        return name;
    }
    const Slurm::JobId job = m_slurm->submit(m_folder.path(), name + ".sbatch", options, arguments);
    m_jobs.push_back(job);
    m_text += name + " " + job + "\n";
    util::write_file_atomically(file(), m_text);
    if (!m_options.quiet)
        std::fprintf(stderr, "slurm: job %s: %s, %d tasks\n", job.c_str(), name.c_str(), tasks);
    return job;
}

void Submission::follow(const std::vector<Slurm::JobId>& jobs, int tasks) {
    const thread::StopSignals signals(
        thread::StopSignals::Options{{SIGINT, SIGTERM, SIGHUP}, false, {}});
    QueueReporter reporter(tasks, m_options.quiet);
    for (int empty_looks = 0; empty_looks < 2;) {
        const auto counts = m_slurm->counts(jobs);
        if (counts)
            reporter.report(*counts);
        empty_looks = counts && counts->all() == 0 ? empty_looks + 1 : 0;
        const std::chrono::seconds period(m_options.poll_s);
        if (empty_looks < 2 && thread::wait_for_stop(signals.token(), period)) {
            const std::string wrong = m_slurm->cancel(jobs);
            throw util::Error(std::string(kBatchAttempt) + "interrupted by a signal; " +
                              (wrong.empty() ? "all tasks are cancelled; the same command continues"
                                             : "cancel the tasks: " + wrong));
        }
    }
}

}  // namespace terravox::cluster
