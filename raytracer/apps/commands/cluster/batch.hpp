#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/apps/commands/cluster/job.hpp"

namespace terravox::cluster {

/// The beginning of every message about a batch of jobs.
inline constexpr const char* kBatchAttempt = "run the batch: ";

/// The jobs submitted for one command. They are recorded in the job's folder (jobs.txt: a name and
/// a number per line), so that the same command finds them again. Not thread-safe.
class Submission {
public:
    /// The references must outlive it.
    /// @param slurm nullptr: a dry run, which prints to standard output what would be submitted
    Submission(const SlurmOptions& options, const JobFolder& folder, const Slurm* slurm);

    /// Waits for jobs of an earlier call that have not ended.
    /// @throws Error when the options forbid waiting, or a signal arrives
    void wait_for_earlier();

    /// @param name of the script, without .sbatch
    /// @param tasks of the job, for the report
    /// @return its number; in a dry run its name
    /// @throws Error
    Slurm::JobId submit(const std::string& name, const std::vector<std::string>& options, int tasks,
                        const std::vector<std::string>& arguments = {});

    /// Waits until none of its jobs is left in the queue.
    /// @throws Error when a signal arrives: all jobs are cancelled
    void follow() { follow(m_jobs, m_tasks); }

private:
    [[nodiscard]] std::filesystem::path file() const { return m_folder.path() / "jobs.txt"; }
    void follow(const std::vector<Slurm::JobId>& jobs, int tasks);

    const SlurmOptions& m_options;
    const JobFolder& m_folder;
    const Slurm* m_slurm;
    std::vector<Slurm::JobId> m_before;
    std::vector<Slurm::JobId> m_jobs;
    std::string m_text;
    int m_tasks = 0;
};

/// What batches of frames and batches of parts have in common. Not thread-safe.
class Batch {
protected:
    /// Examines what is to be rendered; nothing is submitted yet.
    /// @throws Error, UsageError
    Batch(const SlurmOptions& options, ForwardedArguments passed);
    ~Batch() = default;

    /// @return nullptr in a dry run
    [[nodiscard]] const Slurm* slurm() const { return m_slurm ? &*m_slurm : nullptr; }
    [[nodiscard]] int array_limit() const;
    /// The program's command with the forwarded arguments.
    [[nodiscard]] Command command(const std::string& name) const;
    [[nodiscard]] std::string logs() const { return (m_folder.path() / "logs").string(); }

    /// Submits an array that prepares LiDAR squares, and then `name`.sbatch for these tasks, as
    /// arrays one after the other.
    /// @return job numbers, ":1:2", for --dependency
    std::string submit_tasks(Submission& submission, const std::string& name,
                             const std::vector<int>& tasks) const;

    const SlurmOptions& m_options;
    ForwardedArguments m_passed;
    JobFolder m_folder;

private:
    void find_squares();
    std::vector<std::string> submit_bake(Submission& submission) const;

    std::optional<Slurm> m_slurm;
    int m_bake_tasks = 0;
};

[[nodiscard]] util::ExitCode run_frames(const SlurmOptions& options, ForwardedArguments passed);
[[nodiscard]] util::ExitCode run_parts(const SlurmOptions& options, ForwardedArguments passed);

}  // namespace terravox::cluster
