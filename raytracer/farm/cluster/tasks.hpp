#pragma once

#include <string>
#include <vector>

#include "common/util/process.hpp"
#include "common/util/text.hpp"
#include "raytracer/farm/cluster/template.hpp"

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

struct Engine;

/// Bash code of one kind of task, the same for every scheduler: a template of
/// config/cluster/scripts with its values. Programs replace the shell (exec), so that signals of
/// schedulers reach them.
struct Body {
    std::string script;  ///< its name: "frames"
    Values values;
    bool is_numbered = false;  ///< whether it has {{task}}, the number of its task
    /// Of a job that joins what others make: what is for {{waits}} where it has to wait for them.
    std::string wait_word = {};
    /// @throws Error, UsageError as fill()
    [[nodiscard]] std::string text(const Engine& engine) const;
};

/// Runs a command.
/// @param about what it does, a line of a comment
[[nodiscard]] Body command_body(const Command& command, const std::string& about);
/// Renders the frames of one task.
/// @param command to which --first and --last are added
[[nodiscard]] Body frames_body(const Command& command, const TaskPlan& plan);
/// Fails and lists the missing frames, if any; otherwise runs `command` or, if it is empty, reports
/// that all frames exist.
/// @param pattern of the frames' names
/// @throws UsageError for an invalid pattern
[[nodiscard]] Body merge_frames_body(const std::string& pattern, util::IntRange frames,
                                     const Command& command);

/// An array of tasks that are independent of each other, and a job that joins what they have made.
struct ArrayJob {
    std::string name;        ///< of the job
    std::string tasks_name;  ///< of the array, lower case: "frames"
    std::string join_name;   ///< of the job at the end: "merge"
    int tasks = 1;
    Body task;
    Body join;     ///< once all tasks have ended
    int cpus = 0;  ///< per task; 0: not specified
    int memory_mib = 0;
    int join_cpus = 0;
    int join_memory_mib = 0;
};

/// Frames as a job of a scheduler that this program does not control.
struct FrameJob {
    std::string name;     ///< of the job
    Command animate;      ///< program, "animate", arguments without ranges and video
    std::string pattern;  ///< of the frames' names
    TaskPlan plan;
    std::string video;   ///< empty: none
    int cpus = 0;        ///< per task; 0: not specified
    int memory_mib = 0;  ///< per task; 0: not specified
};
/// @throws UsageError for an invalid pattern
[[nodiscard]] ArrayJob array_of_frames(const FrameJob& job);

}  // namespace terravox::cluster
