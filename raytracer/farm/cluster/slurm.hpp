#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/farm/cluster/tasks.hpp"

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

/// Resources that a task requests from Slurm.
struct Needs {
    int cpus = 0;        ///< 0: a whole node
    int memory_mib = 0;  ///< 0: all of a whole node's, else the cluster's default
    std::string partition;
    std::string time;                ///< in the format of sbatch --time; empty: the partition's
    std::vector<std::string> extra;  ///< further lines for sbatch: "--account=film --qos=low"
    /// @throws UsageError for values that would not remain one word, or one line, of a script
    void check() const;
};

/// What all scripts of a job have in common.
struct JobPlace {
    std::filesystem::path program;  ///< absolute; must exist on every node
    /// Directory that relative paths of the arguments start from; absolute; must exist on every
    /// node.
    std::filesystem::path work;
    Needs needs;
};

// Scripts for sbatch, as text that can be read, changed, and submitted by hand from the job's
// folder. A comment at the head of each states what it does. Output goes to logs/ in the folder
// that they are submitted from. Programs replace the shell (exec), so that Slurm's signals reach
// them.

/// Workers that join a coordinator.
/// @param address host:port; empty: read from `address_file`, once a coordinator's job has written
/// it
struct PoolScript {
    std::string address;
    std::filesystem::path address_file;
    std::filesystem::path token_file;
};
[[nodiscard]] std::string pool_script(const JobPlace& place, const PoolScript& pool);

/// The coordinator as a job. It finds a free port, and writes host:port to `address_file`.
/// @param host name by which workers reach it; empty: the node's own name
/// @param command a complete one, to which --listen is added
[[nodiscard]] std::string coordinator_script(const JobPlace& place, const Command& command,
                                             const std::string& host,
                                             const std::filesystem::path& address_file);

/// Prepares LiDAR squares with `terravox cluster bake`.
/// @param passed "render", "animate" or the kind of an analysis, whose arguments `words` are
[[nodiscard]] std::string bake_script(const JobPlace& place, const std::string& passed,
                                      const Command& words, int tasks);

/// Renders frames.
/// @param command to which --first and --last are added. Argument 1 of the script: number of the
/// array's first task, where there are several arrays.
[[nodiscard]] std::string frames_script(const JobPlace& place, const Command& command,
                                        const TaskPlan& plan);

/// Checks that all frames exist, and then runs `command` or, if it is empty, reports it.
[[nodiscard]] std::string merge_frames_script(const JobPlace& place, const std::string& pattern,
                                              util::IntRange frames, const Command& command);

/// Renders parts of one picture or raster to files of tiles next to it.
/// @param command to which --part is added
[[nodiscard]] std::string parts_script(const JobPlace& place, const Command& command, int parts);
/// Joins the parts.
/// @param arguments of `terravox merge`, after the parts: -o and the files to write
/// @param picture for which the parts were rendered: the first output of their command
[[nodiscard]] std::string merge_parts_script(const JobPlace& place, const Command& arguments,
                                             int parts, const std::filesystem::path& picture);

/// A task of an array. Argument 1 of the script: number of the array's first task, where there are
/// several arrays.
[[nodiscard]] std::string array_tasks_script(const JobPlace& place, const ArrayJob& job);
/// What joins the tasks' results.
[[nodiscard]] std::string array_join_script(const JobPlace& place, const ArrayJob& job);
/// A script for bash that submits TASKS.sbatch as arrays one after the other, then JOIN.sbatch,
/// once all of them have ended.
/// @param folder with both, which logs/ is in; absolute
/// @param nodes simultaneous tasks
[[nodiscard]] std::string submission_script(const std::filesystem::path& folder,
                                            const ArrayJob& job, int nodes);

}  // namespace terravox::cluster
