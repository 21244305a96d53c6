#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/out/country/plan.hpp"

namespace terravox::country {

enum class TaskState { kWaiting, kRunning, kFailed, kDone };

struct TaskStatus {
    int number = 0;
    TaskState state = TaskState::kWaiting;
    double share = 0;  ///< of the shard that is made, 0 to 1
    /// Of the call that finished it, or goes on; 0: unknown.
    double wall_s = 0;
    double cpu_s = 0;
    double peak_mib = 0;
    std::uint64_t holes = 0;  ///< boxes
    std::string host;
    std::string error;  ///< of kFailed, one line
};

struct CountryStatus {
    std::vector<TaskStatus> tasks;
    /// The archive, where it was patched since its shards were joined: all is done then, and what
    /// it lacks stands in it.
    std::optional<std::filesystem::path> patched;
    std::uint64_t patched_holes = 0;  ///< boxes of the finest level
    [[nodiscard]] int count(TaskState state) const noexcept;
    [[nodiscard]] std::uint64_t holes() const noexcept;
    /// Of all work, by the plan's estimate, 0 to 1.
    double share = 0;
    /// With the tasks that run now at their speed; nullopt: none runs, or their speed is unknown.
    std::optional<double> left_s;
};

/// What shards, locks, journals and records of the plan's folder say.
[[nodiscard]] CountryStatus find_status(const PlanFolder& folder, const Plan& plan);

[[nodiscard]] std::string to_text(const CountryStatus& status, const Plan& plan);
[[nodiscard]] std::string to_json(const CountryStatus& status, const Plan& plan);

/// A time for people: "45 s", "12 min", "3.2 h".
[[nodiscard]] std::string duration_text(double seconds);

}  // namespace terravox::country
