#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "raytracer/farm/cluster/slurm.hpp"

namespace terravox::cluster {

/// A command line that a job runs, apart from its program.
struct JobCommand {
    std::string command;  ///< "render", "animate", or the kind of an analysis
    Command words;        ///< as given, without those removed by take()
    std::vector<std::string> outputs;
    std::string animation;  ///< file; of `animate`
    std::string video;

    /// The words that begin the command line: {"render"}, {"animate"} or {"analyse", KIND}.
    [[nodiscard]] Command beginning() const;
    /// The whole command line of a program.
    [[nodiscard]] Command with_program(const std::string& program) const;
    /// Removes an option with its values from `words`.
    /// @param names such as {"-o", "--output"}
    void take(const std::vector<std::string>& names);
    /// Whether an option is among `words`, as --name or --name=value.
    [[nodiscard]] bool has(const std::string& name) const;
    void add(const Command& more) { words.insert(words.end(), more.begin(), more.end()); }
};

/// Renders one picture with workers that Slurm starts: this process runs the coordinator, or
/// follows its job, and cancels the workers when it ends, however it ends.
/// @param threads that the scene asks for; nullopt: it does not say
/// @return the picture's exit code
/// @throws Error, UsageError
[[nodiscard]] util::ExitCode run_pool(const SlurmOptions& options, const JobFolder& folder,
                                      JobCommand render, std::optional<int> threads);

/// The jobs submitted for one command, as independent tasks. They are recorded in the job's folder
/// (jobs.txt: a name and a number per line), so that the same command finds them again. In a dry
/// run what would be submitted is printed to standard output. Not thread-safe.
class Batch {
public:
    /// The references must outlive it.
    /// @throws Error when Slurm is not installed here, and this is no dry run
    Batch(const SlurmOptions& options, const JobFolder& folder);

    /// Tasks that prepare LiDAR squares before all others (`terravox cluster bake`); 0: none.
    void set_bake_tasks(int tasks) { m_bake_tasks = tasks; }

    /// Renders the frames of an animation that are not done, each of which `animate` names.
    /// @return kHoles when frames have holes; kDone also when it does not wait
    /// @throws Error, UsageError
    [[nodiscard]] util::ExitCode run_frames(JobCommand command);
    /// Renders one picture or raster in parts, and joins them.
    /// @param command that makes the parts: its output is theirs
    /// @param joining further arguments of `terravox merge`: -o and the files to write
    [[nodiscard]] util::ExitCode run_parts(const JobCommand& command, const Command& joining);

private:
    [[nodiscard]] std::filesystem::path file() const { return m_folder.path() / "jobs.txt"; }
    void wait_for_earlier() const;
    Slurm::JobId submit(const std::string& name, const std::vector<std::string>& options, int tasks,
                        const std::vector<std::string>& arguments = {});
    std::string submit_tasks(const JobCommand& command, const std::string& name,
                             const std::vector<int>& tasks);
    void follow(const std::vector<Slurm::JobId>& jobs, int tasks) const;

    const SlurmOptions& m_options;
    const JobFolder& m_folder;
    std::optional<Slurm> m_slurm;
    int m_bake_tasks = 0;
    std::vector<Slurm::JobId> m_before;
    std::vector<Slurm::JobId> m_jobs;
    std::string m_text;
    int m_tasks = 0;
};

}  // namespace terravox::cluster
