#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "voxelserver/out/country/plan.hpp"

namespace terravox::country {

/// User and system time of this process, seconds.
[[nodiscard]] double used_cpu_s();
/// Most resident memory of this process so far.
[[nodiscard]] double used_peak_mib();

/// How a task went, as far as it is known: for reports. Whether a shard is there, its file alone
/// says.
struct TaskRecord {
    enum class State { kRunning, kFailed, kDone };
    std::string plan;  ///< Plan::id()
    State state = State::kRunning;
    std::int64_t begun = 0;  ///< Unix time
    double wall_s = 0;       ///< of the call that finished it, as the rest
    double cpu_s = 0;
    double peak_mib = 0;
    std::uint64_t holes = 0;
    std::string host;
    std::string error;  ///< one line; of kFailed
};

/// @throws Error
void write_record(const std::filesystem::path& file, const TaskRecord& record);
/// @return nullopt when there is none, or it is damaged
[[nodiscard]] std::optional<TaskRecord> read_record(const std::filesystem::path& file);

/// Which task comes next on a machine that runs several at once. Neighbouring shards read the same
/// squares, so a place goes on with the neighbour of the task that it has finished, and places
/// begin far from each other: squares are then decoded once, and never by two at the same time. Not
/// thread-safe.
class TaskQueue {
public:
    /// @param waiting numbers of tasks
    explicit TaskQueue(const std::vector<int>& waiting)
        : m_waiting(waiting.begin(), waiting.end()) {}

    [[nodiscard]] bool empty() const noexcept { return m_waiting.empty(); }
    /// Takes a task.
    /// @param after the task that the place has finished; 0: none
    /// @return nullopt: none is waiting
    [[nodiscard]] std::optional<int> take(int after);
    /// A task that was taken has ended.
    void ended(int number) { m_running.erase(number); }
    /// It has ended, and is to be taken again.
    void put_back(int number) {
        ended(number);
        m_waiting.insert(number);
    }

private:
    std::set<int> m_waiting;
    std::set<int> m_running;
};

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
[[nodiscard]] Holes list_holes(const PlanFolder& folder, int number);

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
