#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "raytracer/cluster/slurm.hpp"
#include "raytracer/cluster/slurm_scripts.hpp"
#include "raytracer/commands/cluster/forwarded_arguments.hpp"

namespace terravox::cluster {

/// What a person asks of `terravox cluster slurm`.
struct SlurmOptions {
    Needs needs;
    int nodes = 1;                  ///< that work at once
    std::filesystem::path folder;   ///< of the job; empty: jobs/NAME of the picture
    std::filesystem::path program;  ///< empty: the one that runs
    int poll_s = 5;                 ///< between looks at the queue
    bool dry_run = false, quiet = false;
    // One picture by workers:
    bool coordinator_in_job = false;
    std::string address;  ///< what workers call the coordinator's machine; empty: its host name
    int port = 0;         ///< 0: a free one
    // Many frames, or parts of a picture:
    bool batch = false, wait = true, bake = true;
    std::string frames;       ///< "A-B"; empty: all
    int frames_per_task = 0;  ///< 0: usual_per_task
    int parts = 0;            ///< 0: none
};

/// The folder of a job: scripts, logs/, and what else a mode keeps there. Absolute; made when it is
/// not there.
class JobFolder {
public:
    /// @param options whose folder, program and needs count @param picture name for the folder when
    /// none was given @throws Error, UsageError
    JobFolder(const SlurmOptions& options, const std::string& picture);

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }
    [[nodiscard]] const JobPlace& place() const noexcept { return m_place; }
    /// Writes a script; bash can run it. @throws Error
    void write_script(const std::string& name, const std::string& text) const;
    /// Writes what nobody else may read (mode 0600), over what is there. @throws Error
    void write_secret(const std::string& name, const std::string& text) const;

private:
    std::filesystem::path m_path;
    JobPlace m_place;
};

/// Tells a person on standard error what the queue holds of a job: a line for each change.
class QueueTeller {
public:
    QueueTeller(int tasks, bool quiet) : m_tasks(tasks), m_quiet(quiet) {}
    void tell(const Slurm::Counts& counts);

private:
    int m_tasks;
    bool m_quiet, m_told = false;
    Slurm::Counts m_last;
};

/// One picture by workers that Slurm starts: this process keeps the coordinator, and cancels the
/// workers when it ends, however it ends.
/// @return the picture's exit code @throws Error, UsageError
[[nodiscard]] util::ExitCode run_pool(const SlurmOptions& options,
                                      const std::vector<std::string>& words);

/// Frames of an animation, or parts of a picture, as tasks that know nothing of each other. What is
/// done already is not submitted again.
/// @return kDone; kHoles when frames have holes; kDone too when it does not wait @throws Error,
/// UsageError
[[nodiscard]] util::ExitCode run_batch(const SlurmOptions& options,
                                       const std::vector<std::string>& words);

}  // namespace terravox::cluster
