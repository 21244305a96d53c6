#include "voxelserver/out/country/task_record.hpp"

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/util/atomic_file.hpp"

namespace terravox::country {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 3> kStates = {"running", "failed", "done"};

}  // namespace

void write_record(const std::filesystem::path& file, const TaskRecord& record) {
    const Json out{
        {"plan", record.plan},   {"state", kStates.at(static_cast<std::size_t>(record.state))},
        {"begun", record.begun}, {"wall_s", record.wall_s},
        {"cpu_s", record.cpu_s}, {"peak_mib", record.peak_mib},
        {"holes", record.holes}, {"host", record.host},
        {"error", record.error}};
    util::write_file_atomically(file,
                                out.dump(1, ' ', false, Json::error_handler_t::replace) + "\n",
                                util::Links::kReplace);
}

std::optional<TaskRecord> read_record(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in)
        return std::nullopt;
    const Json json = Json::parse(in, nullptr, false);
    try {
        TaskRecord out;
        out.plan = json.at("plan").get<std::string>();
        const auto state = json.at("state").get<std::string>();
        for (std::size_t i = 0; i < kStates.size(); ++i)
            if (state == kStates[i])
                out.state = static_cast<TaskRecord::State>(i);
        out.begun = json.at("begun").get<std::int64_t>();
        out.wall_s = json.at("wall_s").get<double>();
        out.cpu_s = json.at("cpu_s").get<double>();
        out.peak_mib = json.at("peak_mib").get<double>();
        out.holes = json.at("holes").get<std::uint64_t>();
        out.host = json.at("host").get<std::string>();
        out.error = json.at("error").get<std::string>();
        return out;
    } catch (const Json::exception&) {
        return std::nullopt;
    }
}

}  // namespace terravox::country
