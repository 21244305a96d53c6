#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "voxelserver/out/country/plan_folder.hpp"

namespace terravox::country {

/// A shard that is there, whole.
struct FinishedShard {
    std::uint64_t bytes = 0;
    std::vector<std::string> damage;  ///< of the data, as far as was met
};
/// By header, index and end of the file; boxes are not read.
/// @return nullopt when there is none, or one that is damaged or of another plan
[[nodiscard]] std::optional<FinishedShard> finished_shard(const PlanFolder& folder,
                                                          const Plan& plan, int number);

/// The boxes of a shard that could not be made.
struct Holes {
    std::uint64_t boxes = 0;           ///< of the finest level
    std::vector<std::string> reasons;  ///< different ones, the first kMaxReasons
    static constexpr std::size_t kMaxReasons = 20;
};
/// @throws Error when the shard cannot be read
[[nodiscard]] Holes holes_of(const PlanFolder& folder, int number);

struct TaskOptions {
    int threads = 0;  ///< 0: one for each core
    /// Folder for decoded squares, which may be shared; empty: one of its own in the plan's, which
    /// is removed in the end.
    std::filesystem::path scratch;
    std::uint64_t scratch_bytes = 0;  ///< limit of that folder; 0: that of the plan
    bool quiet = false;
    std::stop_token stop;
};

/// What one call did.
struct TaskOutcome {
    bool made = false;  ///< false: the shard was there
    FinishedShard shard;
    Holes holes;
};

/// Makes a shard of a plan, unless it is there. Killed at any time, the next call goes on; a shard
/// appears under its name when it is whole and on the disk.
/// @throws UsageError for a number out of range; Error when the plan is not of this program and
/// these data (check_current()), when another process makes the shard, when stopped, and when it
/// cannot be written
TaskOutcome make_shard(const PlanFolder& folder, const Plan& plan, int number,
                       const TaskOptions& options);

}  // namespace terravox::country
