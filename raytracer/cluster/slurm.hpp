#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/cluster/child.hpp"

namespace terravox::cluster {

/// Slurm, through its commands: sbatch, squeue, scancel, scontrol. Not thread-safe.
class Slurm {
public:
    /// @throws Error when they are not installed here
    Slurm();

    using JobId = std::string;  ///< number of a job, or of an array as a whole

    /// Submits a script. @param options of sbatch, beside those in the script @param folder the
    /// job's folder, in which the script lies
    /// @throws Error with what sbatch says
    [[nodiscard]] JobId submit(const std::filesystem::path& folder, const std::string& script,
                               const std::vector<std::string>& options,
                               const std::vector<std::string>& arguments = {}) const;

    struct Counts {
        int running = 0, waiting = 0;
        [[nodiscard]] int all() const noexcept { return running + waiting; }
        bool operator==(const Counts&) const = default;
    };
    /// Tasks of these jobs that are not over. A task that lost its node waits some minutes by
    /// Slurm's rule before it runs again: it is let run at once.
    /// @return nullopt when squeue has no answer: the controller may be away for a moment
    [[nodiscard]] std::optional<Counts> counts(const std::vector<JobId>& jobs) const;

    /// Ends jobs, whether they run or wait; those that are over are left alone. @return what is
    /// wrong, empty: nothing
    std::string cancel(const std::vector<JobId>& jobs) const noexcept;

    /// Numbers of an array's tasks are below this. @throws Error when the controller has no answer
    [[nodiscard]] int array_limit() const;
    /// State and exit code of a job that is over, as long as the controller remembers it. @return
    /// nullopt: it runs or waits, or is forgotten
    [[nodiscard]] std::optional<int> exit_code(const JobId& job) const;
};

}  // namespace terravox::cluster
