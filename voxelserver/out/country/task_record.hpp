#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace terravox::country {

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

}  // namespace terravox::country
