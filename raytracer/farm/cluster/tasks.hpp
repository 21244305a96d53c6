#pragma once

#include <string>

#include "common/util/process.hpp"
#include "common/util/text.hpp"
#include "raytracer/farm/cluster/template.hpp"

namespace terravox::cluster {

using util::Command;
[[nodiscard]] Command extend(Command command, const Command& more);

struct Engine;

/// Frames divided among tasks 0, 1 ...: each has a run of `per_task`, the last one the remainder.
struct TaskPlan {
    util::IntRange frames;
    int per_task = 1;
    [[nodiscard]] int tasks() const noexcept { return (frames.count() + per_task - 1) / per_task; }
};

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

/// Frames of an animation, and their video.
struct FrameJob {
    std::string name;     ///< of the job
    Command animate;      ///< program, "animate", arguments without ranges and video
    std::string pattern;  ///< of the frames' names
    TaskPlan plan;
    std::string video = {};  ///< empty: none
};
/// The join fails and lists the missing frames, if any.
/// @throws UsageError for an invalid pattern
[[nodiscard]] ArrayJob array_of_frames(const FrameJob& job, const Engine& engine);

/// One picture or raster in parts.
struct PartJob {
    Command render;     ///< program, "render" or "analyse" and its kind, arguments
    std::string parts;  ///< the output among them, which names the files of tiles
    int count = 2;
    Command files;  ///< arguments of `terravox merge`: -o and what to write
};
[[nodiscard]] ArrayJob array_of_parts(const PartJob& job, const Engine& engine);

}  // namespace terravox::cluster
