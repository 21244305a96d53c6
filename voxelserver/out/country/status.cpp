#include "voxelserver/out/country/status.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "common/util/files.hpp"
#include "common/util/text.hpp"
#include "voxelserver/out/country/join.hpp"
#include "voxelserver/out/country/task.hpp"
#include "voxelserver/out/export/archive/archive_export.hpp"

namespace terravox::country {
namespace {

double since(std::int64_t begun) {
    const auto now = std::chrono::duration_cast<std::chrono::seconds>(
                         std::chrono::system_clock::now().time_since_epoch())
                         .count();
    return static_cast<double>(std::max<std::int64_t>(0, now - begun));
}

TaskStatus status_of_task(const PlanFolder& folder, const Plan& plan, int number) {
    TaskStatus out;
    out.number = number;
    const auto record = read_record(folder.record(number));
    const bool is_of_plan = record && record->plan == plan.id();
    if (is_of_plan) {
        out.wall_s = record->wall_s;
        out.cpu_s = record->cpu_s;
        out.peak_mib = record->peak_mib;
        out.host = record->host;
        out.holes = record->holes;
    }
    if (finished_shard(folder, plan, number)) {
        out.state = TaskState::kDone;
        out.share = 1;
        if (!is_of_plan || record->state != TaskRecord::State::kDone)
            out.holes = list_holes(folder, number).boxes;
        return out;
    }
    out.holes = 0;
    const PlannedShard& shard = plan.shards[static_cast<std::size_t>(number) - 1];
    const auto made = exports::finished_subtrees(folder.shard(number), plan.job(),
                                                 {number, static_cast<int>(plan.shards.size())});
    if (shard.subtrees > 0)
        out.share = std::min(1.0, static_cast<double>(made) / static_cast<double>(shard.subtrees));
    if (util::FileLock::is_taken(folder.lock(number))) {
        out.state = TaskState::kRunning;
        out.wall_s = is_of_plan ? since(record->begun) : 0;
    } else if (is_of_plan && record->state == TaskRecord::State::kFailed) {
        out.state = TaskState::kFailed;
        out.error = record->error;
    }
    return out;
}

/// Seconds of the plan that one second of a running task makes.
double measure_speed(const CountryStatus& status, const Plan& plan) {
    double planned_s = 0;
    double wall_s = 0;
    for (const TaskStatus& task : status.tasks) {
        if (task.state != TaskState::kDone && task.state != TaskState::kRunning)
            continue;
        if (task.wall_s <= 0)
            continue;
        planned_s += task.share * plan.shards[static_cast<std::size_t>(task.number) - 1].cpu_s;
        wall_s += task.wall_s;
    }
    return wall_s > 0 ? planned_s / wall_s : 0;
}

constexpr const char* to_name(TaskState state) noexcept {
    switch (state) {
        case TaskState::kWaiting: return "waiting";
        case TaskState::kRunning: return "running";
        case TaskState::kFailed: return "failed";
        case TaskState::kDone: return "done";
    }
    return "";
}

}  // namespace

int CountryStatus::count(TaskState state) const noexcept {
    return static_cast<int>(std::count_if(tasks.begin(), tasks.end(),
                                          [&](const TaskStatus& t) { return t.state == state; }));
}

std::uint64_t CountryStatus::holes() const noexcept {
    std::uint64_t sum = patched_holes;
    for (const TaskStatus& task : tasks)
        sum += task.holes;
    return sum;
}

CountryStatus find_status(const PlanFolder& folder, const Plan& plan) {
    CountryStatus out;
    out.patched = patched_archive(folder, plan);
    if (out.patched) {
        for (int number = 1; number <= static_cast<int>(plan.shards.size()); ++number) {
            TaskStatus& task = out.tasks.emplace_back();
            task.number = number;
            task.state = TaskState::kDone;
            task.share = 1;
        }
        out.patched_holes = make_report(folder, plan).holes;
        out.share = 1;
        return out;
    }
    double all_s = 0;
    double made_s = 0;
    for (int number = 1; number <= static_cast<int>(plan.shards.size()); ++number) {
        out.tasks.push_back(status_of_task(folder, plan, number));
        const double planned_s = plan.shards[static_cast<std::size_t>(number) - 1].cpu_s;
        all_s += planned_s;
        made_s += planned_s * out.tasks.back().share;
    }
    if (all_s > 0)
        out.share = made_s / all_s;
    else if (out.count(TaskState::kDone) == static_cast<int>(out.tasks.size()))
        out.share = 1;
    const int running = out.count(TaskState::kRunning);
    if (const double speed = measure_speed(out, plan); speed > 0 && running > 0)
        out.left_s = (all_s - made_s) / (speed * running);
    return out;
}

std::string duration_text(double seconds) {
    constexpr double kMinute_s = 60;
    constexpr double kHour_s = 3600;
    if (seconds < 2 * kMinute_s)
        return fmt::format("{:.0f} s", seconds);
    if (seconds < 2 * kHour_s)
        return fmt::format("{:.0f} min", seconds / kMinute_s);
    return fmt::format("{:.1f} h", seconds / kHour_s);
}

std::string to_text(const CountryStatus& status, const Plan& plan) {
    std::string out = fmt::format(
        "{} of {} shards done, {} running, {} failed, {} waiting; {:.0f} % of the work\n",
        status.count(TaskState::kDone), plan.shards.size(), status.count(TaskState::kRunning),
        status.count(TaskState::kFailed), status.count(TaskState::kWaiting), status.share * 100);
    if (status.patched)
        out += fmt::format("{}: patched since, {} boxes are holes\n",
                           util::printable(status.patched->string()), status.patched_holes);
    if (status.left_s)
        out += fmt::format("about {} left\n", duration_text(*status.left_s));
    for (const TaskStatus& task : status.tasks) {
        if (task.state == TaskState::kRunning)
            out +=
                fmt::format("shard {}: running on {}, {:.0f} %\n", task.number,
                            util::printable(task.host.empty() ? "?" : task.host), task.share * 100);
        if (task.state == TaskState::kFailed)
            out += fmt::format("shard {}: failed: {}\n", task.number, util::printable(task.error));
        if (task.holes > 0)
            out += fmt::format("shard {}: {} boxes are holes\n", task.number, task.holes);
    }
    for (const MissingSquare& square : plan.missing)
        out += fmt::format("missing: {}: {}\n", util::printable(square.name),
                           util::printable(square.reason));
    return out;
}

std::string to_json(const CountryStatus& status, const Plan& plan) {
    using Json = nlohmann::ordered_json;
    Json out{{"shards", plan.shards.size()},
             {"done", status.count(TaskState::kDone)},
             {"running", status.count(TaskState::kRunning)},
             {"failed", status.count(TaskState::kFailed)},
             {"waiting", status.count(TaskState::kWaiting)},
             {"share", status.share},
             {"left_s", status.left_s ? Json(*status.left_s) : Json(nullptr)},
             {"holes", status.holes()},
             {"patched", status.patched ? Json(status.patched->string()) : Json(nullptr)},
             {"missing", Json::array()},
             {"tasks", Json::array()}};
    for (const MissingSquare& square : plan.missing)
        out["missing"].push_back({{"name", square.name}, {"reason", square.reason}});
    for (const TaskStatus& task : status.tasks) {
        const PlannedShard& shard = plan.shards[static_cast<std::size_t>(task.number) - 1];
        out["tasks"].push_back({{"task", task.number},
                                {"state", to_name(task.state)},
                                {"share", task.share},
                                {"planned_cpu_s", shard.cpu_s},
                                {"cpu_s", task.cpu_s},
                                {"wall_s", task.wall_s},
                                {"peak_mib", task.peak_mib},
                                {"holes", task.holes},
                                {"host", task.host},
                                {"error", task.error}});
    }
    return out.dump(2, ' ', true, Json::error_handler_t::replace);
}

}  // namespace terravox::country
