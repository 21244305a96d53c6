#include "raytracer/farm/cluster/shard_runner.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "common/thread/parallel.hpp"
#include "common/thread/stop.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/folders.hpp"
#include "common/util/log.hpp"
#include "common/util/process.hpp"
#include "voxelserver/out/country/task.hpp"
#include "voxelserver/out/export/archive/archive_export.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::cluster {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Tasks that end one after the other, none well: what is wrong is not theirs, as a full disk.
constexpr int kFailuresInARow = 3;
/// A task that a signal ended is made again so often: it may have been too much for the memory.
constexpr int kTries = 3;

class Runner {
public:
    Runner(const country::PlanFolder& folder, const country::Plan& plan,
           const RunnerOptions& options, const std::stop_token& stop)
        : m_folder(folder),
          m_plan(plan),
          m_stop(stop),
          m_waiting(unfinished()),
          m_queue(m_waiting),
          m_jobs(count_jobs(options.jobs)),
          m_threads(options.threads > 0
                        ? options.threads
                        : std::max(1, thread::thread_count(0) / static_cast<int>(m_jobs))),
          m_slots(m_jobs),
          m_meter("shards", steps(), options.quiet) {}

    void run() {
        show();
        auto next_look = Clock::now();
        while (true) {
            for (Slot& slot : m_slots)
                if (!slot.child)
                    begin(slot);
            if (!is_busy() && m_elsewhere.empty() && (m_queue.empty() || gives_up()))
                break;
            constexpr std::chrono::milliseconds kPeriod{50};
            if (thread::wait_for_stop(m_stop, kPeriod))
                interrupt();
            for (Slot& slot : m_slots)
                look_at(slot);
            if (Clock::now() < next_look)
                continue;
            next_look = Clock::now() + std::chrono::seconds(1);
            look_elsewhere();
            show();
        }
        show();
        m_meter.finish();
        std::error_code ignored;
        fs::remove_all(scratch(), ignored);
        fs::remove(m_folder.scratch(), ignored);  // where nothing else is in it
        if (!m_failed.empty())
            throw failure();
    }

private:
    /// What runs one task at a time.
    struct Slot {
        std::unique_ptr<util::Process> child;
        int number = 0;  ///< of the task that runs, or ran last
    };

    [[nodiscard]] int count() const { return static_cast<int>(m_plan.shards.size()); }
    [[nodiscard]] std::vector<int> unfinished() const {
        std::vector<int> out;
        for (int number = 1; number <= count(); ++number)
            if (!country::finished_shard(m_folder, m_plan, number))
                out.push_back(number);
        return out;
    }
    [[nodiscard]] std::size_t count_jobs(int wanted) const {
        const int most = std::max(1, static_cast<int>(m_waiting.size()));
        return static_cast<std::size_t>(std::clamp(thread::thread_count(wanted), 1, most));
    }
    [[nodiscard]] std::uint64_t steps() const {
        std::uint64_t sum = 0;
        for (const int number : m_waiting)
            sum += count_subtrees(number);
        return sum;
    }
    /// One for all tasks here, so that neighbours share what is decoded.
    [[nodiscard]] fs::path scratch() const { return m_folder.scratch() / "shared"; }
    [[nodiscard]] bool is_busy() const {
        return std::any_of(m_slots.begin(), m_slots.end(),
                           [](const Slot& slot) { return slot.child != nullptr; });
    }
    [[nodiscard]] bool gives_up() const { return m_failures_in_a_row >= kFailuresInARow; }

    void begin(Slot& slot) {
        while (!gives_up()) {
            const auto number = m_queue.take(slot.number);
            if (!number)
                return;
            if (util::FileLock::is_taken(m_folder.lock(*number))) {
                m_queue.ended(*number);
                m_elsewhere.push_back(*number);
                continue;
            }
            slot.number = *number;
            const std::uint64_t mib = (m_plan.scratch_bytes >> 20) * m_jobs;
            slot.child = std::make_unique<util::Process>(util::Process::Start{
                .command = {util::beside_program("terravox-raytracer").string(), "country", "run",
                            m_folder.path().string(), "--task", std::to_string(*number),
                            "--threads", std::to_string(m_threads), "--scratch", scratch().string(),
                            "--scratch-mib", std::to_string(mib), "--quiet"},
                .log = m_folder.log(*number)});
            return;
        }
    }

    void look_at(Slot& slot) {
        if (!slot.child)
            return;
        const auto status = slot.child->wait(std::chrono::milliseconds(0));
        if (!status)
            return;
        slot.child.reset();
        ended(slot.number, *status);
    }

    void ended(int number, int status) {
        if (country::finished_shard(m_folder, m_plan, number)) {
            m_queue.ended(number);
            m_finished += count_subtrees(number);
            m_failures_in_a_row = 0;
            return;
        }
        if (util::FileLock::is_taken(m_folder.lock(number))) {
            m_queue.ended(number);
            m_elsewhere.push_back(number);
            return;
        }
        constexpr int kSignals = 128;
        const bool by_signal = status > kSignals;
        if (by_signal && ++m_tries[number] < kTries) {
            util::log_warn("shard {}: its task was ended by signal {}; it goes on", number,
                           status - kSignals);
            m_queue.put_back(number);
            return;
        }
        m_queue.ended(number);
        ++m_failures_in_a_row;
        std::string why = by_signal ? "ended by signal " + std::to_string(status - kSignals)
                                    : describe_error(number, status);
        m_failed.emplace_back(number, why + "; see " + m_folder.log(number).string());
    }

    /// What a task has said of its failure. On a full disk it could not even do that.
    [[nodiscard]] std::string describe_error(int number, int status) const {
        const auto record = country::read_record(m_folder.record(number));
        std::string why = "exit code " + std::to_string(status);
        if (record && !record->error.empty())
            why = record->error;
        constexpr std::uintmax_t kFull_bytes = std::uintmax_t{1} << 20;
        std::error_code failed;
        const auto disk = fs::space(m_folder.path(), failed);
        if (!failed && disk.available < kFull_bytes)
            why += "; the disk of the plan is full";
        return why;
    }

    /// Shards whose other process has ended are done, or wait again.
    void look_elsewhere() {
        for (const int number : std::exchange(m_elsewhere, {})) {
            if (util::FileLock::is_taken(m_folder.lock(number)))
                m_elsewhere.push_back(number);
            else if (country::finished_shard(m_folder, m_plan, number))
                m_finished += count_subtrees(number);
            else
                m_queue.put_back(number);
        }
    }

    [[nodiscard]] std::uint64_t count_subtrees(int number) const {
        return m_plan.shards[static_cast<std::size_t>(number) - 1].subtrees;
    }
    /// Of a shard that is being made.
    [[nodiscard]] std::uint64_t count_made(int number) const {
        return std::min<std::uint64_t>(
            count_subtrees(number),
            exports::finished_subtrees(m_folder.shard(number), m_plan.job(), {number, count()}));
    }
    void show() {
        std::uint64_t done = m_finished;
        for (const Slot& slot : m_slots)
            done += slot.child ? count_made(slot.number) : 0;
        for (const int number : m_elsewhere)
            done += count_made(number);
        m_meter.add(done > m_shown ? done - std::exchange(m_shown, done) : 0);
    }

    [[noreturn]] void interrupt() {
        for (Slot& slot : m_slots)
            slot.child.reset();  // ends it
        m_meter.finish();
        throw util::Error("run the plan " + m_folder.path().string() +
                          ": interrupted; the same command goes on");
    }

    [[nodiscard]] util::Error failure() const {
        std::string more;
        if (m_failed.size() > 1)
            more = "; " + std::to_string(m_failed.size() - 1) + " more failed";
        return util::Error("run the plan " + m_folder.path().string() + ": shard " +
                           std::to_string(m_failed.front().first) + " of " +
                           std::to_string(count()) + " failed: " + m_failed.front().second + more +
                           "; the same command goes on");
    }

    const country::PlanFolder& m_folder;
    const country::Plan& m_plan;
    const std::stop_token m_stop;
    const std::vector<int> m_waiting;  ///< at the beginning
    country::TaskQueue m_queue;
    const std::size_t m_jobs;
    const int m_threads;
    std::vector<Slot> m_slots;
    std::vector<int> m_elsewhere;  ///< that other processes make
    std::map<int, int> m_tries;    ///< that signals ended
    int m_failures_in_a_row = 0;
    std::vector<std::pair<int, std::string>> m_failed;
    exports::Meter m_meter;
    std::uint64_t m_finished = 0;  ///< subtrees of shards that are done
    std::uint64_t m_shown = 0;     ///< subtrees that the meter has
};

}  // namespace

void make_all_shards(const country::PlanFolder& folder, const country::Plan& plan,
                     const RunnerOptions& options, const std::stop_token& stop) {
    Runner(folder, plan, options, stop).run();
}

}  // namespace terravox::cluster
