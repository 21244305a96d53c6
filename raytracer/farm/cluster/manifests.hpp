#pragma once

#include <string>
#include <vector>

#include "raytracer/farm/cluster/tasks.hpp"

namespace terravox::cluster {

/// Frames as a job of a scheduler that this program does not control.
struct FrameJob {
    std::string name;     ///< of the job
    Command animate;      ///< program, "animate", arguments without ranges and video
    std::string pattern;  ///< of the frames' names
    /// Directory that relative paths start from; empty: where the scheduler starts tasks.
    std::string work;
    TaskPlan plan;
    std::string video;   ///< empty: none
    int cpus = 0;        ///< per task; 0: not specified
    int memory_mib = 0;  ///< per task; 0: not specified
};

/// The frames as an array of tasks, and what joins them.
/// @throws UsageError for an invalid pattern
[[nodiscard]] ArrayJob array_of_frames(const FrameJob& job);

/// A job template of Open Job Description, version 2023-09, as JSON: two steps, the second after
/// the first.
/// @throws UsageError for arguments that the format cannot represent: "{{" and "}}"
[[nodiscard]] std::string openjd_array(const ArrayJob& job);

/// Where pods run, and with which volume.
struct PodPlace {
    std::string image;
    std::string claim;  ///< persistent volume claim that all pods mount
    /// Mount point in the pods; relative paths of the arguments start there.
    std::string mount = "/data";
    int nodes = 1;  ///< simultaneous pods
    /// @throws UsageError for values that Kubernetes would reject
    void check(const std::string& name) const;
};

/// Two Jobs: tasks by index, and a join that waits for them. A List in JSON, for kubectl.
/// @throws UsageError
[[nodiscard]] std::string kubernetes_array(const ArrayJob& job, const PodPlace& place);

/// One picture: a Job with the coordinator, a Service in front of it, and a Job of workers, which
/// end with it. The token is taken from the Secret NAME-token, key `token`, which is not written
/// here.
/// @param render program, "render" or "analyse" and its kind, arguments
/// @throws UsageError
[[nodiscard]] std::string kubernetes_pool(const std::string& name, const Command& render, int cpus,
                                          int memory_mib, const PodPlace& place);

}  // namespace terravox::cluster
