#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/util/process.hpp"
#include "common/util/text.hpp"

namespace terravox::cluster {

using util::Command;

/// Frames divided among tasks 0, 1 ...: each has a run of `per_task`, the last one the remainder.
struct TaskPlan {
    util::IntRange frames;
    int per_task = 1;
    [[nodiscard]] int tasks() const noexcept { return (frames.count() + per_task - 1) / per_task; }
    [[nodiscard]] int find_task(int frame) const noexcept {
        return (frame - frames.first) / per_task;
    }
};

/// Default number of frames per task: a node gets about eight tasks. Fewer would leave nodes idle
/// at the end; each additional one opens the world again, and costs the scheduler some tenths of a
/// second.
[[nodiscard]] int usual_per_task(int frames, int nodes) noexcept;

/// @param sorted ascending, without duplicates
/// @return "0-3,7,9-10", in the format of sbatch --array
[[nodiscard]] std::string array_text(const std::vector<int>& sorted);

/// The tasks of one job array. Task n of the plan is number n - `offset` of the array.
struct ArrayPiece {
    int offset = 0;
    std::vector<int> indices;
};
/// Splits tasks into arrays, because schedulers limit the numbers of an array.
/// @param tasks ascending
/// @param limit exclusive limit of the numbers of an array; at least 1
[[nodiscard]] std::vector<ArrayPiece> array_pieces(const std::vector<int>& tasks, int limit);

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

// Bash code for the tasks of every scheduler.

/// Renders the frames of one task.
/// @param command to which --first and --last are added
/// @param task the task's number as a bash expression: "$1"
[[nodiscard]] std::string frames_body(const Command& command, const TaskPlan& plan,
                                      const std::string& task);

/// Fails and lists the missing frames, if any; otherwise runs `command` or, if it is empty, reports
/// that all frames exist.
/// @param pattern of the frames' names
/// @throws UsageError for an invalid pattern
[[nodiscard]] std::string merge_frames_body(const std::string& pattern, util::IntRange frames,
                                            const Command& command);

}  // namespace terravox::cluster
