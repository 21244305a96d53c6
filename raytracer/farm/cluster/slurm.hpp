#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/farm/cluster/child.hpp"

namespace terravox::cluster {

/// Interface to Slurm through its commands: sbatch, squeue, scancel, scontrol. Not thread-safe.
class Slurm {
public:
    /// @throws Error when they are not installed here
    Slurm();

    using JobId = std::string;  ///< number of a job, or of an array as a whole

    /// Submits a script.
    /// @param options of sbatch, in addition to those in the script
    /// @param folder the job's folder, which contains the script
    /// @throws Error with sbatch's message
    [[nodiscard]] JobId submit(const std::filesystem::path& folder, const std::string& script,
                               const std::vector<std::string>& options,
                               const std::vector<std::string>& arguments = {}) const;

    struct Counts {
        int running = 0;
        int waiting = 0;
        [[nodiscard]] int all() const noexcept { return running + waiting; }
        bool operator==(const Counts&) const = default;
    };
    /// Number of tasks of these jobs that have not ended. A task that lost its node would by
    /// Slurm's rule wait some minutes before it runs again: it is released at once.
    /// @return nullopt when squeue fails: the controller may be unavailable for a moment
    [[nodiscard]] std::optional<Counts> counts(const std::vector<JobId>& jobs) const;

    /// Ends jobs, whether running or waiting; jobs that have ended are ignored.
    /// @return an error message; empty: none
    std::string cancel(const std::vector<JobId>& jobs) const noexcept;

    /// Upper limit, exclusive, of the task numbers of an array.
    /// @throws Error when the controller does not answer
    [[nodiscard]] int array_limit() const;
    /// State and exit code of a job that has ended, as long as the controller remembers it.
    /// @return nullopt: it is running, waiting or forgotten
    [[nodiscard]] std::optional<int> exit_code(const JobId& job) const;
};

}  // namespace terravox::cluster
