#include "voxelserver/out/country/task.hpp"

#include <sys/resource.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/log.hpp"
#include "common/util/process.hpp"
#include "common/voxel/archive/archive_parts.hpp"
#include "common/voxel/archive/archive_reader.hpp"
#include "voxelserver/out/country/inputs.hpp"
#include "voxelserver/out/country/plan.hpp"
#include "voxelserver/out/country/workload.hpp"
#include "voxelserver/out/export/archive/archive_export.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::country {
namespace {

struct rusage used() {
    struct rusage out{};
    ::getrusage(RUSAGE_SELF, &out);
    return out;
}

double seconds(const timeval& t) noexcept {
    constexpr double kMicro = 1e-6;
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * kMicro;
}

}  // namespace

double used_cpu_s() {
    const struct rusage now = used();
    return seconds(now.ru_utime) + seconds(now.ru_stime);
}

double used_peak_mib() {
    constexpr double kKibOfMib = 1024;
    return static_cast<double>(used().ru_maxrss) / kKibOfMib;
}

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

namespace {

/// Numbers that follow each other, both included.
struct Run {
    int first = 0;
    int last = -1;
    [[nodiscard]] int count() const noexcept { return last - first + 1; }
};

Run longest_run(const std::set<int>& numbers) {
    Run longest;
    Run run;
    for (const int number : numbers) {
        if (run.count() > 0 && number == run.last + 1)
            run.last = number;
        else
            run = {number, number};
        if (run.count() > longest.count())
            longest = run;
    }
    return longest;
}

}  // namespace

std::optional<int> TaskQueue::take(int after) {
    if (m_waiting.empty())
        return std::nullopt;
    int number = after + 1;
    if (after == 0 || !m_waiting.contains(number)) {
        const Run run = longest_run(m_waiting);
        const bool follows = m_running.contains(run.first - 1);
        number = follows ? run.first + run.count() / 2 : run.first;
    }
    m_waiting.erase(number);
    m_running.insert(number);
    return number;
}

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using voxel::archive::ArchiveIndex;

std::string describe_attempt(const Plan& plan, int number) {
    return "make shard " + std::to_string(number) + " of " + std::to_string(plan.shards.size());
}

/// Makes one shard; the caller has its lock.
class Task {
public:
    Task(const PlanFolder& folder, const Plan& plan, int number, const TaskOptions& options)
        : m_folder(folder), m_plan(plan), m_number(number), m_options(options) {
        m_record.plan = plan.id();
        m_record.begun = std::chrono::duration_cast<std::chrono::seconds>(
                             std::chrono::system_clock::now().time_since_epoch())
                             .count();
        m_record.host = util::host_name();
    }

    TaskOutcome run() {
        write_record(m_folder.record(m_number), m_record);
        try {
            TaskOutcome out = make();
            m_record.state = TaskRecord::State::kDone;
            m_record.holes = out.holes.boxes;
            close_record();
            return out;
        } catch (const std::exception& e) {
            if (!m_options.stop.stop_requested())
                note_failure(e.what());
            throw;
        }
    }

private:
    void note_failure(const std::string& error) {
        m_record.state = TaskRecord::State::kFailed;
        m_record.error = error;
        try {
            close_record();
        } catch (const util::Error& e) {
            util::log_error("{}", e.what());  // the disk may be full
        }
    }

    TaskOutcome make() {
        check_current(m_plan, describe_attempt(m_plan, m_number));
        const ScratchFolder own(m_folder.scratch() / std::to_string(m_number));
        worlds::WorldOptions options = m_plan.world;
        options.threads = m_options.threads;
        options.known_squares = m_folder.known_squares();
        options.chunk_indices = m_folder.chunks();
        options.cache_dir = m_options.scratch.empty() ? own.path() : m_options.scratch;
        options.cache_bytes =
            m_options.scratch_bytes > 0 ? m_options.scratch_bytes : m_plan.scratch_bytes;
        write(options);
        // What changes while it is read must not become part of an archive.
        if (const auto changes = changes_since(m_plan); !changes.empty()) {
            std::error_code ignored;
            fs::remove(m_folder.shard(m_number), ignored);
            throw util::Error(describe_attempt(m_plan, m_number) +
                              ": the data changed meanwhile: " + changes.front());
        }
        TaskOutcome out;
        out.made = true;
        const auto finished = finished_shard(m_folder, m_plan, m_number);
        if (!finished)
            throw util::Error(describe_attempt(m_plan, m_number) + ": " +
                              m_folder.shard(m_number).string() + " cannot be read back");
        out.shard = *finished;
        out.holes = list_holes(m_folder, m_number);
        return out;
    }

    void write(const worlds::WorldOptions& options) {
        OpenedCountry country(options, m_plan.selection());
        if (country.fingerprint() != m_plan.fingerprint || country.part().bounds != m_plan.bounds)
            throw util::Error(describe_attempt(m_plan, m_number) +
                              ": settings, class table or palette have changed since the plan was "
                              "made; plan again");
        const PlannedShard& shard = m_plan.shards[static_cast<std::size_t>(m_number) - 1];
        exports::Meter meter("shard " + std::to_string(m_number), shard.subtrees, m_options.quiet);
        exports::Job job(country.world(), country.part(), m_folder.shard(m_number),
                         country.palette(), meter);
        job.name = m_plan.job();
        job.threads = m_options.threads;
        job.stop = m_options.stop;
        for (const fs::path& file : m_plan.world.left_out)
            job.left_out.push_back(file.filename().string() + " was left out: it cannot be read");
        exports::write_archive(job, {m_number, static_cast<int>(m_plan.shards.size())});
        meter.finish();
    }

    void close_record() {
        m_record.wall_s = std::chrono::duration<double>(Clock::now() - m_start).count();
        m_record.cpu_s = used_cpu_s();
        m_record.peak_mib = used_peak_mib();
        write_record(m_folder.record(m_number), m_record);
    }

    const PlanFolder& m_folder;
    const Plan& m_plan;
    const int m_number;
    const TaskOptions& m_options;
    const Clock::time_point m_start = Clock::now();
    TaskRecord m_record;
};

}  // namespace

std::optional<FinishedShard> finished_shard(const PlanFolder& folder, const Plan& plan,
                                            int number) {
    const fs::path file = folder.shard(number);
    std::error_code failed;
    if (!fs::exists(file, failed))
        return std::nullopt;
    try {
        const auto source = voxel::archive::file_source(file);
        const ArchiveIndex index(*source, ArchiveIndex::Of::kAnyFile);
        if (index.kind() != voxel::archive::FileKind::kShard)
            return std::nullopt;
        const voxel::archive::Shard shard = voxel::archive::read_shard(*source, index);
        if (shard.job != plan.job() || shard.number != number ||
            shard.of != static_cast<int>(plan.shards.size()))
            return std::nullopt;
        return FinishedShard{index.header().file_bytes, shard.damage};
    } catch (const util::Error& e) {
        util::log_warn("{}; it is made again", e.what());
        return std::nullopt;
    }
}

Holes list_holes(const PlanFolder& folder, int number) {
    const auto source = voxel::archive::file_source(folder.shard(number));
    const ArchiveIndex index(*source, ArchiveIndex::Of::kAnyFile);
    Holes out;
    std::vector<std::byte> room;
    for (std::size_t leaf = 0; leaf < index.leaves().size(); ++leaf) {
        if (index.leaves()[leaf].first.level > 0)
            break;  // sorted by level
        for (const voxel::archive::Entry& entry : index.entries(leaf)) {
            if (entry.kind != voxel::archive::Kind::kHole || entry.key.level > 0)
                continue;
            ++out.boxes;
            if (out.reasons.size() == Holes::kMaxReasons)
                continue;
            const auto bytes = source->read(entry.offset, entry.bytes, room);
            std::string reason(reinterpret_cast<const char*>(bytes.data()), bytes.size());
            if (std::find(out.reasons.begin(), out.reasons.end(), reason) == out.reasons.end())
                out.reasons.push_back(std::move(reason));
        }
    }
    return out;
}

TaskOutcome make_shard(const PlanFolder& folder, const Plan& plan, int number,
                       const TaskOptions& options) {
    if (number < 1 || number > static_cast<int>(plan.shards.size()))
        throw util::UsageError("run the plan: --task " + std::to_string(number) +
                               "; allowed: 1 to " + std::to_string(plan.shards.size()));
    folder.make_folders();
    const auto lock = util::FileLock::try_take(folder.lock(number));
    if (!lock)
        throw util::Error(describe_attempt(plan, number) + ": " +
                          util::FileLock::holder(folder.lock(number)) + " makes it");
    if (const auto there = finished_shard(folder, plan, number))
        return {false, *there, list_holes(folder, number)};
    // Who writes an archive follows a link that a user has named; these names are our own.
    std::error_code ignored;
    if (fs::is_symlink(folder.shard(number), ignored))
        throw util::Error(describe_attempt(plan, number) + ": " + folder.shard(number).string() +
                          " is a symbolic link, which is not followed; allowed: none");
    return Task(folder, plan, number, options).run();
}

}  // namespace terravox::country
