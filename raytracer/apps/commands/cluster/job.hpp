#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "raytracer/apps/commands/cluster/forwarded_arguments.hpp"
#include "raytracer/farm/cluster/slurm.hpp"

namespace terravox::cluster {

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
    /// @param options of which folder, program and needs are used
    /// @param picture name for the folder if none was given
    /// @throws Error, UsageError
    JobFolder(const SlurmOptions& options, const std::string& picture);

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }
    [[nodiscard]] const JobPlace& place() const noexcept { return m_place; }
    /// Writes a script for bash.
    /// @throws Error
    void write_script(const std::string& name, const std::string& text) const;
    /// Writes a file that only its owner can read (mode 0600), replacing an existing one.
    /// @throws Error
    void write_secret(const std::string& name, const std::string& text) const;

private:
    std::filesystem::path m_path;
    JobPlace m_place;
};

/// Prints the state of a job's queue on standard error: a line for each change.
class QueueReporter {
public:
    QueueReporter(int tasks, bool quiet) : m_tasks(tasks), m_quiet(quiet) {}
    void report(const Slurm::Counts& counts);

private:
    int m_tasks;
    bool m_quiet;
    bool m_reported = false;
    Slurm::Counts m_last;
};

/// Renders one picture with workers that Slurm starts: this process runs the coordinator, and
/// cancels the workers when it ends, however it ends.
/// @return the picture's exit code
/// @throws Error, UsageError
[[nodiscard]] util::ExitCode run_pool(const SlurmOptions& options,
                                      const std::vector<std::string>& words);

/// Renders frames of an animation, or parts of a picture, as independent tasks. Finished ones are
/// not submitted again.
/// @return kDone; kHoles when frames have holes; kDone also when it does not wait
/// @throws Error, UsageError
[[nodiscard]] util::ExitCode run_batch(const SlurmOptions& options,
                                       const std::vector<std::string>& words);

}  // namespace terravox::cluster
