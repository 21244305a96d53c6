#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "raytracer/commands/cluster/job.hpp"

namespace terravox::cluster {

/// What has been submitted of one job. It is written down in the job's folder (jobs.txt: a name and
/// a number a line), so that the same command finds it again. Not thread-safe.
class Submission {
public:
    /// The references must outlive it. @param slurm nullptr: a dry run, which says on standard
    /// output what would be submitted
    Submission(const SlurmOptions& options, const JobFolder& folder, const Slurm* slurm);

    /// Jobs of an earlier call that are still at work: waits for them. @throws Error when it shall
    /// not wait, or a signal comes
    void wait_for_earlier();

    /// @param name of the script, without .sbatch @param tasks of the job, for the report @return
    /// its number; in a dry run its name @throws Error
    Slurm::JobId submit(const std::string& name, const std::vector<std::string>& options, int tasks,
                        const std::vector<std::string>& arguments = {});

    /// Until nothing of it is left in the queue. @throws Error when a signal comes: all is
    /// cancelled
    void follow() { follow(m_jobs, m_tasks); }

private:
    [[nodiscard]] std::filesystem::path file() const { return m_folder.path() / "jobs.txt"; }
    void follow(const std::vector<Slurm::JobId>& jobs, int tasks);

    const SlurmOptions& m_options;
    const JobFolder& m_folder;
    const Slurm* m_slurm;
    std::vector<Slurm::JobId> m_before, m_jobs;
    std::string m_text;
    int m_tasks = 0;
};

}  // namespace terravox::cluster
