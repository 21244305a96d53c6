#include "voxelserver/serve/jobs/job_queue.hpp"

#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <system_error>

#include "common/thread/start_threads.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "voxelserver/serve/jobs/job_process.hpp"

namespace terravox::jobs {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLook{100};
constexpr std::chrono::minutes kSweep{1};
constexpr const char* kResult = "result.tif";
/// Bytes of the values of a cell, in a file that compresses nothing, and its overviews.
constexpr std::uint64_t kCellBytes = std::uint64_t{16} * sizeof(float) * 2;
constexpr std::uint64_t kFileBytes = std::uint64_t{64} << 20;  ///< that any file may have

/// 128 random bits as hexadecimal digits.
std::string new_id() {
    std::array<unsigned char, 16> bytes{};
    if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
        throw util::Error("name a job: the system has no random numbers");
    constexpr const char* kDigits = "0123456789abcdef";
    std::string out;
    for (const unsigned char byte : bytes) {
        out += kDigits[byte >> 4];
        out += kDigits[byte & 15];
    }
    return out;
}

std::uint64_t measure_file_bytes(const JobRequest& request) {
    return kFileBytes + static_cast<std::uint64_t>(request.cells) * kCellBytes;
}

/// Room on the disk of a folder, bytes; 0 where that is not known.
std::uint64_t room_in(const fs::path& folder) {
    std::error_code failed;
    const fs::space_info space = fs::space(folder, failed);
    return failed ? 0 : space.available;
}

std::uint64_t measure_size(const fs::path& file) {
    std::error_code failed;
    const std::uint64_t size = fs::file_size(file, failed);
    return failed ? 0 : size;
}

bool is_finished(JobState state) {
    return state == JobState::kDone || state == JobState::kFailed;
}

JobStatus failed(std::string message) {
    JobStatus out;
    out.state = JobState::kFailed;
    out.message = std::move(message);
    return out;
}

/// How a process has ended by itself.
JobStatus ended(int code, const std::string& said, const fs::path& file) {
    const bool is_done = code == static_cast<int>(util::ExitCode::kDone);
    const bool has_holes = code == static_cast<int>(util::ExitCode::kHoles);
    constexpr int kSignalled = 128;
    if (code > kSignalled)
        return failed("it was ended by signal " + std::to_string(code - kSignalled));
    if (!is_done && !has_holes) {
        const std::string reason = reason_in(said);
        return failed(reason.empty() ? "it ended with status " + std::to_string(code) : reason);
    }
    JobStatus out;
    out.state = JobState::kDone;
    out.progress = 1;
    out.has_holes = has_holes;
    out.bytes = measure_size(file);
    return out;
}

}  // namespace

JobQueue::JobQueue(QueueOptions options)
    : m_options(std::move(options)), m_folder(util::TemporaryFolder::make("run jobs")) {
    if (::access(m_options.program.c_str(), X_OK) != 0)
        throw util::Error("run jobs: there is no program " + m_options.program.string() +
                          ", which is a part of Terravox");
    thread::start_threads(
        m_threads, static_cast<std::size_t>(std::max(m_options.running, 1)), [this] { run_jobs(); },
        [this] { stop(); });
}

JobQueue::~JobQueue() {
    stop();
}

void JobQueue::stop() noexcept {
    {
        const std::lock_guard lock(m_mutex);
        m_stopping = true;
    }
    m_changed.notify_all();
    for (std::thread& thread : m_threads)
        if (thread.joinable())
            thread.join();
}

std::optional<std::string> JobQueue::submit(JobRequest request) {
    const bool has_room = room_in(m_folder.path()) > 4 * measure_file_bytes(request);
    if (!has_room)
        util::log_warn("a job is refused: too little room on the disk of {}",
                       m_folder.path().string());
    Job job;
    job.status.id = new_id();
    job.status.kind = request.kind;
    job.request = std::move(request);
    const std::lock_guard lock(m_mutex);
    drop_old();
    const auto waiting = std::count_if(m_jobs.begin(), m_jobs.end(), [](const Job& one) {
        return one.status.state == JobState::kWaiting;
    });
    if (!has_room || m_stopping || static_cast<std::size_t>(waiting) >= m_options.max_waiting)
        return std::nullopt;
    m_jobs.push_back(std::move(job));
    m_changed.notify_one();
    return m_jobs.back().status.id;
}

std::optional<JobStatus> JobQueue::status(const std::string& id) {
    const std::lock_guard lock(m_mutex);
    drop_old();
    const auto found = find(id);
    if (found == m_jobs.end())
        return std::nullopt;
    JobStatus out = found->status;
    out.before = static_cast<std::size_t>(std::count_if(m_jobs.begin(), found, [](const Job& one) {
        return one.status.state == JobState::kWaiting;
    }));
    if (out.state == JobState::kWaiting && out.before == 0 && find_next() == m_jobs.end())
        out.message =
            "it waits for room: each result is kept for some minutes, or until it is "
            "deleted";
    return out;
}

bool JobQueue::remove(const std::string& id) {
    const std::lock_guard lock(m_mutex);
    const auto found = find(id);
    if (found == m_jobs.end())
        return false;
    const bool is_running = found->status.state == JobState::kRunning;
    m_jobs.erase(found);
    if (!is_running)
        remove_folder(id);
    m_changed.notify_all();  // its result leaves room for another
    return true;
}

std::optional<fs::path> JobQueue::result(const std::string& id) {
    const std::lock_guard lock(m_mutex);
    drop_old();
    const auto found = find(id);
    if (found == m_jobs.end() || found->status.state != JobState::kDone)
        return std::nullopt;
    return find_folder(id) / kResult;
}

JobCounts JobQueue::counts() {
    const std::lock_guard lock(m_mutex);
    drop_old();
    JobCounts out;
    for (const Job& job : m_jobs) {
        out.waiting += job.status.state == JobState::kWaiting ? 1 : 0;
        out.running += job.status.state == JobState::kRunning ? 1 : 0;
        out.kept += is_finished(job.status.state) ? 1 : 0;
    }
    return out;
}

void JobQueue::run_jobs() {
    std::unique_lock lock(m_mutex);
    for (;;) {
        // Results end after some time, whether anybody asks or not, and leave room for others.
        while (!m_changed.wait_for(lock, kSweep,
                                   [&] { return m_stopping || find_next() != m_jobs.end(); }))
            drop_old();
        if (m_stopping)
            return;
        const auto job = find_next();
        job->status.state = JobState::kRunning;
        const std::string id = job->status.id;
        const JobRequest request = job->request;
        lock.unlock();
        JobStatus end;
        try {
            end = run(id, request);
        } catch (const std::exception& e) {
            end = failed(e.what());
        }
        if (!end.message.empty())
            util::log_warn("a job, {}: {}", request.kind, end.message);
        lock.lock();
        const auto still = find(id);
        if (still == m_jobs.end() || end.state != JobState::kDone)
            remove_folder(id);
        if (still == m_jobs.end())
            continue;
        end.id = id;
        end.kind = request.kind;
        still->status = end;
        still->finished = Clock::now();
        drop_old();
    }
}

JobStatus JobQueue::run(const std::string& id, const JobRequest& request) {
    const fs::path folder = find_folder(id);
    fs::create_directory(folder);
    ProcessStart start{
        m_options.program, list_words(request), folder, {}, measure_file_bytes(request)};
    if (!m_options.token.empty())
        start.environment = {{"TERRAVOX_SERVER_TOKEN", m_options.token},
                             {"TERRAVOX_SERVER_ORIGIN", m_options.world}};
    JobProcess process(start);
    const JobLimits& limits = m_options.limits;
    const auto deadline = Clock::now() + std::chrono::minutes(limits.max_minutes);
    const std::uint64_t max_bytes = static_cast<std::uint64_t>(limits.memory_mib) << 20;
    while (is_wanted(id)) {
        if (const auto code = process.look())
            return ended(*code, process.said(), folder / kResult);
        set_progress(id, progress_in(process.said()).value_or(0));
        if (Clock::now() > deadline)
            return failed("it took longer than " + std::to_string(limits.max_minutes) +
                          " minutes; allowed: a smaller area, larger cells or a shorter period");
        if (process.resident_bytes() > max_bytes)
            return failed("it used more than " + std::to_string(limits.memory_mib) +
                          " MiB of memory; allowed: a smaller area or larger cells");
        // There was enough when it was submitted; others write, too.
        if (room_in(folder) < m_options.spare_bytes)
            return failed("the server's disk is nearly full; try again later");
        std::this_thread::sleep_for(kLook);
    }
    return failed("");
}

bool JobQueue::is_wanted(const std::string& id) {
    const std::lock_guard lock(m_mutex);
    return !m_stopping && find(id) != m_jobs.end();
}

void JobQueue::set_progress(const std::string& id, double progress) {
    const std::lock_guard lock(m_mutex);
    if (const auto found = find(id); found != m_jobs.end())
        found->status.progress = progress;
}

fs::path JobQueue::find_folder(const std::string& id) const {
    return m_folder.path() / id;
}

void JobQueue::remove_folder(const std::string& id) const noexcept {
    std::error_code ignored;
    fs::remove_all(find_folder(id), ignored);
}

std::vector<std::string> JobQueue::list_words(const JobRequest& request) const {
    std::vector<std::string> out = {"analyse", request.kind, m_options.world, "-o", kResult};
    out.insert(out.end(), request.words.begin(), request.words.end());
    // A half for boxes leaves as much for all else.
    out.push_back("--memory-mib=" + std::to_string(std::max(m_options.limits.memory_mib / 2, 1)));
    out.emplace_back("--cache=none");
    if (m_options.limits.threads > 0)
        out.push_back("--threads=" + std::to_string(m_options.limits.threads));
    return out;
}

JobQueue::Jobs::iterator JobQueue::find(const std::string& id) {
    return std::find_if(m_jobs.begin(), m_jobs.end(),
                        [&](const Job& job) { return job.status.id == id; });
}

/// Whether it has a result that must not be dropped yet to make room for others.
bool JobQueue::must_stay(const Job& job) const {
    return job.status.state == JobState::kDone &&
           Clock::now() - job.finished < m_options.kept_at_least;
}

JobQueue::Jobs::iterator JobQueue::find_next() {
    const auto next = std::find_if(m_jobs.begin(), m_jobs.end(), [](const Job& job) {
        return job.status.state == JobState::kWaiting;
    });
    if (next == m_jobs.end())
        return next;
    std::size_t kept = 1;
    std::uint64_t bytes = measure_file_bytes(next->request);
    for (const Job& job : m_jobs) {
        const bool is_running = job.status.state == JobState::kRunning;
        if (!is_running && !must_stay(job))
            continue;
        ++kept;
        bytes += is_running ? measure_file_bytes(job.request) : job.status.bytes;
    }
    const bool has_room = kept <= m_options.max_kept && bytes <= m_options.max_kept_bytes;
    return has_room || kept == 1 ? next : m_jobs.end();
}

/// Drops finished jobs that are too old, and of those that need not be kept any more the oldest
/// where they are too many or too large.
void JobQueue::drop_old() {
    const auto now = Clock::now();
    std::size_t kept = 0;
    std::uint64_t bytes = 0;
    std::vector<Jobs::iterator> finished;
    for (auto it = m_jobs.begin(); it != m_jobs.end(); ++it)
        if (is_finished(it->status.state))
            finished.push_back(it);
    std::sort(finished.begin(), finished.end(),
              [](const auto& a, const auto& b) { return a->finished > b->finished; });
    for (const auto& it : finished) {
        ++kept;
        bytes += it->status.bytes;
        const bool has_room = kept <= m_options.max_kept && bytes <= m_options.max_kept_bytes;
        // The newest stays, however large: somebody has waited for it.
        const bool stays = has_room || kept == 1 || must_stay(*it);
        if (stays && now - it->finished < m_options.kept)
            continue;
        remove_folder(it->status.id);
        m_jobs.erase(it);
    }
}

}  // namespace terravox::jobs
