#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raytracer/apps/commands/cluster/submission.hpp"

namespace terravox::cluster {

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
