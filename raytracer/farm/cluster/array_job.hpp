#pragma once

#include <functional>
#include <string>

namespace terravox::cluster {

/// An array of tasks that are independent of each other, and a job that joins what they have made.
/// Bash code of both is the same for every scheduler.
struct ArrayJob {
    std::string name;        ///< of the job
    std::string tasks_name;  ///< of the array, lower case: "frames"
    std::string join_name;   ///< of the job at the end: "merge"
    /// Directory that relative paths start from; empty: where the scheduler starts tasks.
    std::string work;
    int tasks = 1;
    /// Bash code of a task.
    /// @param task its number from 0 on, as a bash expression: "$1"
    std::function<std::string(const std::string& task)> task_body;
    std::string join_body;  ///< once all tasks have ended
    /// The same where the scheduler cannot order jobs: waits until all that the tasks make exists.
    std::string waiting_join_body;
    int cpus = 0;        ///< per task; 0: not specified
    int memory_mib = 0;  ///< per task; 0: not specified
    int join_cpus = 0;
    int join_memory_mib = 0;
};

}  // namespace terravox::cluster
