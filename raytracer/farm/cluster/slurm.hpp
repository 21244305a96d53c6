#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "raytracer/farm/cluster/engines.hpp"

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

/// The tasks of some jobs that are in the queue. Prints changes on standard error, a line for each.
class QueueWatch {
public:
    /// @param tasks of all jobs, for what is printed
    QueueWatch(const Slurm& slurm, std::vector<Slurm::JobId> of, int tasks, bool quiet)
        : jobs(std::move(of)), m_slurm(slurm), m_tasks(tasks), m_quiet(quiet) {}
    /// @return how many looks in a row have found the queue empty: one alone is not trusted, as the
    /// controller may be restarting
    [[nodiscard]] int look();
    std::vector<Slurm::JobId> jobs;

private:
    const Slurm& m_slurm;
    int m_tasks;
    bool m_quiet;
    int m_empty_looks = 0;
    std::optional<Slurm::Counts> m_last;
};

/// The options of `terravox cluster slurm`.
struct SlurmOptions {
    Needs needs;
    int nodes = 1;                  ///< number of simultaneous nodes
    std::filesystem::path folder;   ///< of the job; empty: jobs/NAME of the picture
    std::filesystem::path program;  ///< empty: the running one
    int poll_s = 5;                 ///< interval between queries of the queue
    bool dry_run = false;
    bool quiet = false;
    std::string analyse;  ///< kind of an analysis; empty: a picture
    // One picture by workers:
    bool coordinator_in_job = false;
    /// Address of the coordinator's machine for workers; empty: its host name.
    std::string address;
    int port = 0;  ///< 0: any free one
    // Many frames, or parts of a picture:
    bool batch = false;
    bool wait = true;
    bool bake = true;
    std::string frames;       ///< "A-B"; empty: all
    int frames_per_task = 0;  ///< 0: usual_per_task
    int parts = 0;            ///< 0: none
};

/// The folder of a job: scripts, logs/, and further files of each mode. Absolute; created if it
/// does not exist.
class JobFolder {
public:
    /// @param options of which folder, program, nodes and needs are used
    /// @param picture name for the folder if none was given
    /// @throws Error, UsageError
    JobFolder(const SlurmOptions& options, const std::string& picture);

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }
    [[nodiscard]] std::string logs() const { return (m_path / "logs").string(); }
    [[nodiscard]] const Place& place() const noexcept { return m_place; }
    [[nodiscard]] std::string program() const { return m_program.string(); }
    /// Writes FILE.sbatch.
    /// @param name of the job, and of its logs; empty: as the file
    /// @throws Error, UsageError
    void write_script(const std::string& file, SlurmJob job, const Body& body,
                      const std::string& name = {}) const;
    /// Writes a file that only its owner can read (mode 0600), replacing an existing one.
    /// @throws Error
    void write_secret(const std::string& name, const std::string& text) const;

private:
    std::filesystem::path m_path;
    std::filesystem::path m_program;  ///< absolute; must exist on every node
    Place m_place;
};

}  // namespace terravox::cluster
