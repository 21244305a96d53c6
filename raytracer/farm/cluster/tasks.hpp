#pragma once

#include <string>
#include <vector>

#include "common/util/int_range.hpp"

namespace terravox::cluster {

/// Frames divided among tasks 0, 1 ...: each has a run of `per_task`, the last one the remainder.
struct TaskPlan {
    util::IntRange frames;
    int per_task = 1;
    [[nodiscard]] int tasks() const noexcept { return (frames.count() + per_task - 1) / per_task; }
    [[nodiscard]] int task_of(int frame) const noexcept {
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

}  // namespace terravox::cluster
