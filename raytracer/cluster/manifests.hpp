#pragma once

#include <string>
#include <vector>

#include "raytracer/cluster/child.hpp"
#include "raytracer/cluster/tasks.hpp"

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

/// A job template of Open Job Description, version 2023-09, as JSON.
/// @throws UsageError for arguments that the format cannot represent: "{{" and "}}"
[[nodiscard]] std::string openjd_job(const FrameJob& job);

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

/// Two Jobs: frames by index, and a merge that waits for them. A List in JSON, for kubectl.
/// @throws UsageError
[[nodiscard]] std::string kubernetes_frames(const FrameJob& job, const PodPlace& place);

/// One picture: a Job with the coordinator, a Service in front of it, and a Job of workers, which
/// end with it. The token is taken from the Secret NAME-token, key `token`, which is not written
/// here.
/// @param render program, "render" or "analyse" and its kind, arguments
/// @throws UsageError
[[nodiscard]] std::string kubernetes_pool(const std::string& name, const Command& render, int cpus,
                                          int memory_mib, const PodPlace& place);

}  // namespace terravox::cluster
