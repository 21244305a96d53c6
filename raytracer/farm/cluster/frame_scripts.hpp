#pragma once

#include <string>

#include "raytracer/farm/cluster/child.hpp"
#include "raytracer/farm/cluster/tasks.hpp"

namespace terravox::cluster {

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
