#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "raytracer/farm/cluster/tasks.hpp"

namespace terravox::cluster {

/// Resources that a task requests.
struct Needs {
    int cpus = 0;        ///< 0: a whole node
    int memory_mib = 0;  ///< 0: all of a whole node's, else the cluster's default
    // Of Slurm alone:
    std::string partition;
    std::string time;                ///< in the format of sbatch --time; empty: the partition's
    std::vector<std::string> extra;  ///< further lines for sbatch: "--account=film --qos=low"
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

/// Where the tasks of an array run.
struct Place {
    /// Directory that relative paths of the arguments start from; absolute; must exist on every
    /// node. Not of pods.
    std::filesystem::path work;
    Needs needs;                   ///< of Slurm
    PodPlace pods;                 ///< of Kubernetes
    int nodes = 1;                 ///< simultaneous tasks
    std::filesystem::path folder;  ///< of Slurm: with the scripts and logs/; absolute
};

/// What starts an array of tasks.
struct ArrayFiles {
    std::string start;  ///< what is given to the engine
    /// Of Slurm: further files of Place::folder, name and text.
    std::vector<std::pair<std::string, std::string>> scripts;
};

/// A scheduler. Its templates are in the folder of its name in config/cluster.
struct Engine {
    const char* name;
    const char* task;         ///< number of a task, from 0 on, as a bash expression
    int array_limit;          ///< exclusive limit of the numbers of an array; 0: none
    bool orders_jobs;         ///< else a join waits itself for what the tasks make
    bool has_absolute_paths;  ///< of program, data and results: the same on all machines
    /// @throws UsageError for arguments that its format cannot represent
    ArrayFiles (*make_array)(const ArrayJob& job, const Place& place);
};
enum EngineNumber : std::size_t { kSlurm, kOpenJd, kKubernetes };
extern const std::array<Engine, 3> kEngines;

/// How Slurm runs a script.
enum class SlurmJob {
    kArray,  ///< for each number
    kOne,
    kOnce,  ///< one job, which is not requeued when its node fails
};
/// A script for sbatch, as text that can be read, changed, and submitted by hand from the job's
/// folder. Output goes to logs/ there. Of several arrays, argument 1 is the number of the first
/// task.
/// @param name of the job, and of its logs
[[nodiscard]] std::string slurm_script(const Place& place, const std::string& name, SlurmJob job,
                                       const Body& body);

/// One picture: a Job with the coordinator, a Service in front of it, and a Job of workers, which
/// end with it; a List in JSON, for kubectl. The token is taken from the Secret NAME-token, key
/// `token`, which is not written here.
/// @param render program, "render" or "analyse" and its kind, arguments
/// @throws UsageError
[[nodiscard]] std::string kubernetes_pool(const std::string& name, const Command& render,
                                          const Place& place);

/// A worker that joins a coordinator, with what its task has.
/// @param address host:port; empty: read from `address_file`, once a coordinator's job has written
/// it
[[nodiscard]] Body worker_body(const std::string& program, const Needs& needs,
                               const std::string& token_file, const std::string& address,
                               const std::string& address_file);

}  // namespace terravox::cluster
