#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "common/util/folders.hpp"
#include "common/voxel/world.hpp"

namespace terravox::jobs {

/// Bounds of one job.
struct JobLimits {
    std::int64_t max_cells = 4'000'000;
    int max_minutes = 30;
    int memory_mib = 1024;  ///< of its process
    int threads = 0;        ///< 0: one for each core
};

/// A checked request for an analysis.
struct JobRequest {
    std::string kind;  ///< one of voxel::list_analyses()
    std::int64_t cells = 0;
    /// Words of `terravox analyse KIND`, each an option with its value.
    std::vector<std::string> words;
};

/// Reads a request: a JSON object of known names, all of whose values are checked. No text of it
/// can name a file or be an option.
/// @param body untrusted
/// @throws UsageError naming what is wrong, and what is allowed
[[nodiscard]] JobRequest read_job_request(std::string_view body, const voxel::WorldInfo& world,
                                          const JobLimits& limits);

/// What a queue works with.
struct QueueOptions {
    int running = 1;  ///< jobs at the same time, at least 1
    std::size_t max_waiting = 16;
    std::size_t max_kept = 256;  ///< finished jobs
    std::uint64_t max_kept_bytes = std::uint64_t{4} << 30;
    std::chrono::seconds kept{6 * 3600};
    /// No result is dropped for others before that: jobs wait for room instead.
    std::chrono::seconds kept_at_least{15 * 60};
    /// A job ends where the disk of results has less room than that.
    std::uint64_t spare_bytes = std::uint64_t{64} << 20;
    JobLimits limits;
    std::filesystem::path program;  ///< terravox-raytracer
    std::string world;              ///< address that a job reads its boxes from
    std::string token;              ///< of that address; empty: none
};

enum class JobState { kWaiting, kRunning, kDone, kFailed };

struct JobStatus {
    std::string id;
    std::string kind;
    JobState state = JobState::kWaiting;
    std::size_t before = 0;  ///< jobs that wait and were there earlier
    double progress = 0;     ///< 0 to 1
    bool has_holes = false;  ///< data could not be read
    /// Reason of a failure, one line, which may name folders; of a job that waits: why it is not
    /// begun although none is before it.
    std::string message;
    std::uint64_t bytes = 0;  ///< of the result
};

struct JobCounts {
    std::size_t waiting = 0;
    std::size_t running = 0;
    std::size_t kept = 0;
};

/// Analyses that wait, run and are finished. Each runs in a process of its own
/// (docs/adr/0032-jobs-of-the-voxel-server.md). Thread-safe.
///
/// One lock guards the list of jobs. Each thread of the queue takes the first job that waits, once
/// its result has room beside those that must be kept, runs its process without holding the lock,
/// and looks ten times a second whether to stop it. A job
/// that is deleted while it runs leaves the list at once; its thread sees that, ends the process,
/// and removes its folder.
class JobQueue {
public:
    /// @throws Error when there is no folder for results, or no program
    explicit JobQueue(QueueOptions options);
    ~JobQueue();  ///< stop()
    JobQueue(const JobQueue&) = delete;
    JobQueue& operator=(const JobQueue&) = delete;

    /// Adds a job.
    /// @return its secret name; nullopt when too many wait, or the disk has too little room
    [[nodiscard]] std::optional<std::string> submit(JobRequest request);
    /// @return nullopt for an unknown name
    [[nodiscard]] std::optional<JobStatus> status(const std::string& id);
    /// Ends a job, and removes its files.
    /// @return false for an unknown name
    bool remove(const std::string& id);
    /// @return the file of a job that is done; nullopt for any other
    [[nodiscard]] std::optional<std::filesystem::path> result(const std::string& id);
    [[nodiscard]] JobCounts counts();
    [[nodiscard]] const JobLimits& limits() const noexcept { return m_options.limits; }
    /// Ends all jobs, and waits for their processes. Idempotent.
    void stop() noexcept;

private:
    struct Job {
        JobStatus status;
        JobRequest request;
        std::chrono::steady_clock::time_point finished;
    };
    using Jobs = std::list<Job>;

    void run_jobs();
    /// @return how the job has ended
    [[nodiscard]] JobStatus run(const std::string& id, const JobRequest& request);
    [[nodiscard]] bool is_wanted(const std::string& id);
    void set_progress(const std::string& id, double progress);
    [[nodiscard]] std::filesystem::path find_folder(const std::string& id) const;
    void remove_folder(const std::string& id) const noexcept;
    [[nodiscard]] std::vector<std::string> list_words(const JobRequest& request) const;
    // With the lock held:
    [[nodiscard]] Jobs::iterator find(const std::string& id);
    /// @return the job to begin next; the end: none waits, or there is no room for its result
    [[nodiscard]] Jobs::iterator find_next();
    [[nodiscard]] bool must_stay(const Job& job) const;
    void drop_old();

    const QueueOptions m_options;
    util::TemporaryFolder m_folder;
    std::mutex m_mutex;
    std::condition_variable m_changed;
    Jobs m_jobs;  ///< in the order of their coming
    bool m_stopping = false;
    std::vector<std::thread> m_threads;
};

}  // namespace terravox::jobs
