#include "raytracer/apps/commands/country/plan_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/util/printable.hpp"

namespace terravox::commands {
namespace {

using country::Measured;
using country::Plan;
using country::PlannedFile;
using country::PlannedShard;

constexpr double kMega = 1e6;
constexpr double kGiga = 1e9;
constexpr double kHour_s = 3600;

double sum_of(const std::vector<PlannedFile>& files, std::uint64_t PlannedFile::* member) {
    double sum = 0;
    for (const PlannedFile& file : files)
        sum += static_cast<double>(file.*member);
    return sum;
}

std::string bytes_text(double bytes) {
    return bytes < kGiga ? fmt::format("{:.1f} MB", bytes / kMega)
                         : fmt::format("{:.1f} GB", bytes / kGiga);
}

std::string hours_text(const Measured& cpu_s) {
    constexpr double kMinute_s = 60;
    if (cpu_s.value < 2 * kMinute_s)
        return fmt::format("{:.1f} +- {:.1f} core-seconds", cpu_s.value, cpu_s.error);
    if (cpu_s.value < kHour_s)
        return fmt::format("{:.1f} +- {:.1f} core-minutes", cpu_s.value / kMinute_s,
                           cpu_s.error / kMinute_s);
    return fmt::format("{:.1f} +- {:.1f} core-hours", cpu_s.value / kHour_s, cpu_s.error / kHour_s);
}

std::uint64_t most_scratch(const Plan& plan) {
    std::uint64_t most = 0;
    for (const PlannedShard& shard : plan.shards)
        most = std::max(most, shard.scratch_bytes);
    return most;
}

}  // namespace

std::string text_of(const Plan& plan) {
    const auto row = [](std::string_view name, const std::string& text) {
        return fmt::format("{:<8} {}\n", name, text);
    };
    const auto km = [&](std::size_t axis) {
        return (plan.bounds.max[axis] - plan.bounds.min[axis]) * plan.voxel_m / 1000;
    };
    const auto [fewest, most] = std::minmax_element(
        plan.shards.begin(), plan.shards.end(),
        [](const PlannedShard& a, const PlannedShard& b) { return a.cpu_s < b.cpu_s; });
    const country::Estimate& e = plan.estimate;
    std::string out;
    out += row("place", fmt::format("{:.1f} x {:.1f} km in {}, voxels of {} m", km(0), km(2),
                                    util::printable(plan.crs), plan.voxel_m));
    out += row("squares", fmt::format("{}, {:.1f} M points, {}; {} missing", plan.squares.size(),
                                      sum_of(plan.squares, &PlannedFile::points) / kMega,
                                      bytes_text(sum_of(plan.squares, &PlannedFile::bytes)),
                                      plan.missing.size()));
    out += row("shards", fmt::format("{}, of {:.1f} to {:.1f} core-seconds", plan.shards.size(),
                                     fewest->cpu_s, most->cpu_s));
    out += row("time", hours_text(e.cpu_s) + " on a cluster, " + hours_text(e.one_machine_cpu_s) +
                           " on one machine, where tasks share decoded squares");
    out += row("memory", fmt::format("{:.0f} MiB a task", e.memory_mib));
    out += row("scratch", bytes_text(static_cast<double>(most_scratch(plan))) + " a task");
    out += row("output",
               fmt::format("{} +- {}, and as much for the shards", bytes_text(e.output_bytes.value),
                           bytes_text(e.output_bytes.error)));
    return out + row("sample", fmt::format("{} columns of boxes were made", e.sampled_columns));
}

std::string json_of(const Plan& plan, const std::string& folder) {
    using Json = nlohmann::ordered_json;
    const auto measured = [](const Measured& m) {
        return Json{{"value", m.value}, {"error", m.error}};
    };
    const country::Estimate& e = plan.estimate;
    Json out{{"plan", folder},
             {"id", plan.id()},
             {"crs", plan.crs},
             {"voxel_m", plan.voxel_m},
             {"bounds", {{"min", plan.bounds.min}, {"max", plan.bounds.max}}},
             {"squares", plan.squares.size()},
             {"points", sum_of(plan.squares, &PlannedFile::points)},
             {"shards", plan.shards.size()},
             {"sampled_columns", e.sampled_columns},
             {"cpu_s", measured(e.cpu_s)},
             {"one_machine_cpu_s", measured(e.one_machine_cpu_s)},
             {"memory_mib", e.memory_mib},
             {"scratch_bytes", most_scratch(plan)},
             {"output_bytes", measured(e.output_bytes)},
             {"missing", Json::array()}};
    for (const country::MissingSquare& square : plan.missing)
        out["missing"].push_back({{"name", square.name}, {"reason", square.reason}});
    return out.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace terravox::commands
