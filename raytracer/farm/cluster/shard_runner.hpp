#pragma once

#include <stop_token>

#include "voxelserver/out/country/plan.hpp"

namespace terravox::cluster {

struct RunnerOptions {
    int jobs = 0;     ///< tasks at the same time; 0: one for each core
    int threads = 0;  ///< of each task; 0: the cores divided by the tasks
    bool quiet = false;
};

/// Makes all shards of a plan that are not there, each as a process of its own: memory that a task
/// has held goes with it, and one that is killed, by whom or whatever, takes no other with it.
/// Shards that another process makes at the same time are waited for, and made here if that ends.
/// @throws Error when shards fail, or a stop is requested: tasks are ended then, and go on next
/// time
void make_all_shards(const country::PlanFolder& folder, const country::Plan& plan,
                     const RunnerOptions& options, const std::stop_token& stop);

}  // namespace terravox::cluster
