#pragma once

#include <string>
#include <vector>

#include "raytracer/cluster/child.hpp"
#include "raytracer/cluster/tasks.hpp"

namespace terravox::cluster {

/// Frames as a job of any scheduler that is not driven from here.
struct FrameJob {
    std::string name;     ///< of the job
    Command animate;      ///< program, "animate", arguments without ranges and video
    std::string pattern;  ///< of the frames' names
    std::string work;     ///< where relative paths begin; empty: where the scheduler starts tasks
    TaskPlan plan;
    std::string video;   ///< empty: none
    int cpus = 0;        ///< of a task; 0: not said
    int memory_mib = 0;  ///< of a task; 0: not said
};

/// A job template of Open Job Description, version 2023-09, as JSON. @throws UsageError for
/// arguments that it cannot hold: "{{" and "}}"
[[nodiscard]] std::string openjd_job(const FrameJob& job);

/// Where pods run, and with what.
struct PodPlace {
    std::string image;
    std::string claim;            ///< persistent volume claim that all pods mount
    std::string mount = "/data";  ///< there; relative paths of the arguments begin there
    int nodes = 1;                ///< pods at once
    /// @throws UsageError for what Kubernetes would not take
    void check(const std::string& name) const;
};

/// Two Jobs: frames by index, and a merge that waits for them. JSON, as kubectl takes it: a List.
/// @throws UsageError
[[nodiscard]] std::string kubernetes_frames(const FrameJob& job, const PodPlace& place);

/// One picture: a Job with the coordinator, a Service in front of it, a Job of workers, which end
/// with it. The token is of the Secret NAME-token, key `token`, which is not written here. @param
/// render program, "render", arguments @throws UsageError
[[nodiscard]] std::string kubernetes_pool(const std::string& name, const Command& render, int cpus,
                                          int memory_mib, const PodPlace& place);

}  // namespace terravox::cluster
