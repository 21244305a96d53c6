#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "raytracer/cluster/child.hpp"
#include "raytracer/cluster/tasks.hpp"

namespace terravox::cluster {

/// What a task asks Slurm for.
struct Needs {
    int cpus = 0;        ///< 0: a whole node
    int memory_mib = 0;  ///< 0: all of a whole node's, else what the cluster gives
    std::string partition;
    std::string time;                ///< as sbatch --time takes it; empty: the partition's
    std::vector<std::string> extra;  ///< further lines for sbatch: "--account=film --qos=low"
    /// @throws UsageError for what would not stay one word, or one line, of a script
    void check() const;
};

/// What all scripts of a job have in common.
struct JobPlace {
    std::filesystem::path program;  ///< absolute; there on every node
    std::filesystem::path
        work;  ///< where relative paths of the arguments begin, absolute; there on every node
    Needs needs;
};

// Scripts for sbatch, as text: what a person may read, change, and submit by hand from the job's
// folder. Each says at its head what it does. Output goes to logs/ in the folder that they are
// submitted from. Programs replace the shell (exec), so that a signal of Slurm reaches them.

/// Workers that go to a coordinator. @param address host:port; empty: of `address_file`, waited
/// for, in which a coordinator's job writes it
struct PoolScript {
    std::string address;
    std::filesystem::path address_file, token_file;
};
[[nodiscard]] std::string pool_script(const JobPlace& place, const PoolScript& pool);

/// The coordinator as a job. It looks for a free port, and writes host:port to `address_file`.
/// @param host what workers call it; empty: the node's own name @param command a whole one, to
/// which --listen is added
[[nodiscard]] std::string coordinator_script(const JobPlace& place, const Command& command,
                                             const std::string& host,
                                             const std::filesystem::path& address_file);

/// Prepares LiDAR squares, through `terravox cluster bake`. @param passed "render" or "animate",
/// whose arguments `words` are
[[nodiscard]] std::string bake_script(const JobPlace& place, const std::string& passed,
                                      const Command& words, int tasks);

/// Frames. @param command to which --first and --last are added. Argument 1 of the script: number
/// of the array's first task, where there are several arrays.
[[nodiscard]] std::string frames_script(const JobPlace& place, const Command& command,
                                        const TaskPlan& plan);

/// Looks whether all frames are there, and then runs `command`; empty: says so.
[[nodiscard]] std::string merge_frames_script(const JobPlace& place, const std::string& pattern,
                                              Range frames, const Command& command);

/// Parts of one picture: files of tiles beside it. @param command to which --part is added
[[nodiscard]] std::string parts_script(const JobPlace& place, const Command& command, int parts);
/// Joins them. @param outputs pictures to write @param picture that the parts were rendered for:
/// the first output of their command
[[nodiscard]] std::string merge_parts_script(const JobPlace& place,
                                             const std::vector<std::string>& outputs, int parts,
                                             const std::filesystem::path& picture);

}  // namespace terravox::cluster
