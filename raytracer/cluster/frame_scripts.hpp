#pragma once

#include <string>

#include "raytracer/cluster/child.hpp"
#include "raytracer/cluster/tasks.hpp"

namespace terravox::cluster {

// What tasks of every scheduler run, as text for bash.

/// Renders the frames of one task. @param command to which --first and --last are added @param task
/// what the number of the task is, as bash writes it: "$1"
[[nodiscard]] std::string frames_body(const Command& command, const TaskPlan& plan,
                                      const std::string& task);

/// Fails, and names them, when frames are missing; else runs `command`, or says that all are there
/// when it is empty.
/// @param pattern of the frames' names @throws UsageError when it is none
[[nodiscard]] std::string merge_frames_body(const std::string& pattern, Range frames,
                                            const Command& command);

}  // namespace terravox::cluster
