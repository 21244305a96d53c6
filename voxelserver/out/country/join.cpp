#include "voxelserver/out/country/join.hpp"

#include <sys/stat.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/voxel/archive/archive_format.hpp"
#include "common/voxel/archive/archive_reader.hpp"
#include "voxelserver/out/archive/archive_files.hpp"
#include "voxelserver/out/archive/merge.hpp"
#include "voxelserver/out/country/task.hpp"
#include "voxelserver/out/export/archive/archive_export.hpp"

namespace terravox::country {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

bool can_be_opened(const fs::path& archive) {
    try {
        const auto source = voxel::archive::file_source(archive);
        const voxel::archive::ArchiveIndex index(*source);
        return true;
    } catch (const util::Error&) {
        return false;
    }
}

JoinReport report_of_patched(const fs::path& archive) {
    const archive_tools::Summary summary =
        archive_tools::make_summary(archive_tools::ArchiveFiles(archive));
    JoinReport out;
    out.holes = summary.levels.empty() ? 0 : summary.levels.front().holes;
    out.damage = summary.damage;
    if (out.damage > 0)
        out.reasons.push_back(archive.string() + ": " + std::to_string(out.damage) +
                              " places of its data were damaged or left out");
    return out;
}

}  // namespace

void write_target(const PlanFolder& folder, const Target& target) {
    const Json out{{"plan", target.plan},       {"archive", target.archive.string()},
                   {"before", target.before},   {"after", target.after},
                   {"patched", target.patched}, {"is_patched", target.is_patched}};
    util::write_file_atomically(folder.run(),
                                out.dump(1, ' ', false, Json::error_handler_t::replace) + "\n",
                                util::Links::kReplace);
}

std::optional<Target> read_target(const PlanFolder& folder) {
    std::ifstream in(folder.run(), std::ios::binary);
    if (!in)
        return std::nullopt;
    const Json json = Json::parse(in, nullptr, false);
    try {
        return Target{json.at("plan").get<std::string>(),
                      json.at("archive").get<std::string>(),
                      json.at("before").get<std::string>(),
                      json.at("after").get<std::string>(),
                      json.value("patched", ""),
                      json.value("is_patched", false)};
    } catch (const Json::exception&) {
        return std::nullopt;
    }
}

fs::path confirmed_archive(const PlanFolder& folder, const Target& target, const fs::path& named,
                           const std::string& attempt) {
    const std::string archive = target.archive.string();
    if (!named.empty()) {
        std::error_code ignored;
        const bool is_same = fs::absolute(named).lexically_normal() == target.archive ||
                             fs::equivalent(named, target.archive, ignored);
        if (!is_same)
            throw util::UsageError(attempt + ": its run writes " + archive + ", not " +
                                   named.string() + "; allowed: -o " + archive +
                                   ", or terravox country run for another one");
        return target.archive;
    }
    std::error_code failed;
    const fs::path file = fs::weakly_canonical(util::follow_links(target.archive), failed);
    const fs::path& plan = folder.path();
    const bool is_near = file.parent_path() == plan || file.parent_path() == plan.parent_path();
    if (failed || !is_near || file.extension() != voxel::archive::kEnding)
        throw util::UsageError(attempt + ": its run.json names " + archive +
                               ", which is no .tvx file in the plan's folder or beside it; "
                               "allowed: -o " +
                               archive + ", if that is where it shall go");
    return target.archive;
}

std::string state_of_file(const fs::path& file) {
    struct stat found{};
    if (::stat(file.c_str(), &found) != 0)
        return "";
    return std::to_string(found.st_size) + " " + std::to_string(found.st_mtim.tv_sec) + "." +
           std::to_string(found.st_mtim.tv_nsec) + " " + std::to_string(found.st_ino);
}

std::optional<fs::path> patched_archive(const PlanFolder& folder, const Plan& plan) {
    const auto target = read_target(folder);
    if (!target || !target->is_patched || !is_joined(folder, plan, target->archive))
        return std::nullopt;
    return target->archive;
}

bool is_joined(const PlanFolder& folder, const Plan& plan, const fs::path& archive) {
    const std::string now = state_of_file(archive);
    const auto target = read_target(folder);
    if (now.empty() || !target || target->plan != plan.id() || target->archive != archive)
        return false;
    // Killed between the last step and its note: another file than before is the archive, since it
    // gets its name when it is whole.
    const bool is_new = target->after.empty() ? now != target->before : now == target->after;
    return is_new && can_be_opened(archive);
}

JoinReport make_report(const PlanFolder& folder, const Plan& plan) {
    if (const auto archive = patched_archive(folder, plan))
        return report_of_patched(*archive);
    JoinReport out;
    std::set<std::string> reasons;
    std::set<std::string> damage;
    for (int number = 1; number <= static_cast<int>(plan.shards.size()); ++number) {
        const auto shard = finished_shard(folder, plan, number);
        if (!shard)
            continue;
        damage.insert(shard->damage.begin(), shard->damage.end());
        const Holes holes = list_holes(folder, number);
        out.holes += holes.boxes;
        reasons.insert(holes.reasons.begin(), holes.reasons.end());
    }
    out.damage = damage.size();
    out.reasons.assign(reasons.begin(), reasons.end());
    out.reasons.insert(out.reasons.end(), damage.begin(), damage.end());
    constexpr std::size_t kMostLines = 20;
    if (out.reasons.size() > kMostLines)
        out.reasons.resize(kMostLines);
    return out;
}

JoinReport join(const PlanFolder& folder, const Plan& plan, const fs::path& archive, int threads,
                const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
    std::vector<fs::path> shards;
    for (int number = 1; number <= static_cast<int>(plan.shards.size()); ++number)
        shards.push_back(folder.shard(number));
    const archive_tools::MergeReport merged =
        archive_tools::merge(shards, archive, threads, progress);
    for (const fs::path& shard : shards)
        exports::remove_journal(shard);
    Target target = read_target(folder).value_or(Target{plan.id(), archive, "", "", ""});
    target.after = state_of_file(archive);
    write_target(folder, target);
    JoinReport out = make_report(folder, plan);
    out.boxes = merged.records - merged.holes;
    return out;
}

}  // namespace terravox::country
