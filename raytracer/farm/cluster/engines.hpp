#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "common/util/process.hpp"
#include "common/util/text.hpp"
#include "raytracer/farm/cluster/template.hpp"

namespace terravox::cluster {

using util::Command;
[[nodiscard]] Command extend(Command command, const Command& more);

/// Default number of frames per task: a node gets about eight tasks. Fewer would leave nodes idle
/// at the end; each additional one opens the world again, and costs the scheduler some tenths of a
/// second.
[[nodiscard]] int usual_per_task(int frames, int nodes) noexcept;

/// An array of tasks that are independent of each other, and a job that joins what they have made.
/// What they run is bash code, the same for every scheduler: templates of config/cluster/scripts.
/// Programs replace the shell (exec), so that signals of schedulers reach them.
struct ArrayJob {
    std::string name;        ///< of the job
    std::string tasks_name;  ///< of the array, lower case: "frames"
    std::string join_name;   ///< of the job at the end: "merge"
    int tasks = 1;
    std::string task;
    std::string join;           ///< once all tasks have ended
    bool joins_little = false;  ///< one processor, and little memory, are enough for that
    // Of Slurm alone:
    std::string to_do = {};  ///< leaves only tasks that are not done; empty: all are submitted
    std::string bake = {};   ///< what tasks before all others run
    int bakers = 0;          ///< number of these
};

/// Resources that a task requests.
struct Needs {
    int cpus = 0;        ///< 0: a whole node
    int memory_mib = 0;  ///< 0: all of a whole node's, else the cluster's default
    // Of Slurm alone:
    std::string partition = {};
    std::string time = {};  ///< in the format of sbatch --time; empty: the partition's
    /// Further lines for sbatch: "--account=film --qos=low".
    std::vector<std::string> extra = {};
    /// @throws UsageError for values that would not remain one word, or one line, of a script
    void check() const;
};

/// Where pods run, and with which volume.
struct PodPlace {
    std::string image;
    std::string claim;  ///< persistent volume claim that all pods mount
    /// Mount point in the pods; relative paths of the arguments start there.
    std::string mount = "/data";
    /// @throws UsageError for values that Kubernetes would reject
    void check(const std::string& name) const;
};

/// Where the tasks of an array, or workers, run.
struct Place {
    /// Directory that relative paths of the arguments start from; absolute; must exist on every
    /// node. Not of pods.
    std::filesystem::path work = {};
    Needs needs = {};
    PodPlace pods = {};  ///< of Kubernetes
    int nodes = 1;       ///< simultaneous tasks, or workers
    // Of Slurm alone:
    std::filesystem::path folder = {};  ///< with the scripts and logs/; absolute
    bool waits = false;  ///< whether the script that submits follows the jobs to their end
    bool quiet = false;
    int poll_s = 5;  ///< interval between queries of the queue
};

/// One picture by workers.
struct PoolJob {
    std::string name;
    Command render;  ///< program, "render" or "analyse" and its kind, arguments
    // Of Slurm alone:
    bool has_coordinator_job = false;  ///< else the coordinator is a process of this machine
    bool renders = false;              ///< whether the coordinator renders, too
    std::string address = {};          ///< of its machine for workers; empty: its host name
    int port = 0;                      ///< 0: any free one
};

/// What starts a job.
struct JobFiles {
    std::string start;  ///< what is given to the engine
    /// Of Slurm: further files of Place::folder, name and text.
    std::vector<std::pair<std::string, std::string>> scripts = {};
    /// Writes the scripts, and a folder logs/ for what they say.
    /// @throws Error
    void write_scripts(const std::filesystem::path& folder) const;
};

/// A scheduler. Its templates are in the folder of its name in config/cluster.
struct Engine {
    const char* task;  ///< number of a task, from 0 on, as a bash expression
    bool orders_jobs;  ///< else a join waits itself for what the tasks make
    bool runs_here;    ///< this machine submits: all have its program and its paths
    /// @throws UsageError for arguments that its format cannot represent
    JobFiles (*make_array)(const ArrayJob& job, const Place& place);
    JobFiles (*make_pool)(const PoolJob& job, const Place& place);  ///< nullptr: it has none

    [[nodiscard]] Value number() const { return Value::plain(task); }
    /// For {{waits}} of joins.
    [[nodiscard]] Value waits() const {
        return orders_jobs ? std::vector<std::string>{} : std::vector<std::string>{"--wait"};
    }
    /// @param given by the user; empty: the usual one
    [[nodiscard]] std::string find_program(const std::filesystem::path& given) const;
};
enum EngineNumber : std::size_t { kSlurm, kOpenJd, kKubernetes };
extern const std::array<Engine, 3> kEngines;

/// Frames of an animation, divided among tasks, and their video.
struct FrameJob {
    std::string name;     ///< of the job
    Command animate;      ///< program, "animate", arguments without ranges and video
    std::string pattern;  ///< of the frames' names
    util::IntRange frames;
    int per_task = 1;        ///< of the last one the remainder
    std::string video = {};  ///< empty: none
    [[nodiscard]] int tasks() const noexcept { return (frames.count() + per_task - 1) / per_task; }
};
/// The join fails and lists the missing frames, if any.
/// @throws UsageError for an invalid pattern
[[nodiscard]] ArrayJob array_of_frames(const FrameJob& job, const Engine& engine);

/// One picture or raster in parts.
/// @param render program, "render" or "analyse" and its kind, arguments
/// @param output the one among them, which names the files of tiles
/// @param files arguments of `terravox merge`: -o and what to write
[[nodiscard]] ArrayJob array_of_parts(const Command& render, const std::string& output, int count,
                                      const Command& files, const Engine& engine);

}  // namespace terravox::cluster
