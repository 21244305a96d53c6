#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <vector>

#include "raytracer/sched/processor.hpp"
#include "raytracer/trace/tile_job.hpp"

namespace terravox {

/// Tiles on threads of this process.
///
/// One mutex guards: tiles submitted (bounded), jobs begun,
/// jobs that are ready to go on since boxes came, and results. A thread takes a ready job, else begins a tile, and traces without any
/// lock until the job is finished or waits for boxes; then it takes the next. `m_work` wakes threads, `m_room` wakes submitters, `m_done`
/// wakes takers (a result, a failure, or all threads ended). The block manager calls with its own lock held: never call it under m_mutex.
class ThreadProcessor final : public TileProcessor, private BlockListener {
public:
    /// @param threads at least 1; @param view, blocks outlive the processor
    ThreadProcessor(const View& view, BlockManager& blocks, int threads);
    ~ThreadProcessor() override;
    [[nodiscard]] int capacity() const noexcept override { return tiles_in_flight(m_thread_count); }
    void submit(RenderTile tile) override;
    [[nodiscard]] bool wait(std::chrono::milliseconds most) override;
    std::optional<TileResult> take() override;
    void close() noexcept override;
    void cancel() noexcept override;

    /// The capacity of a processor of so many threads.
    [[nodiscard]] static int tiles_in_flight(int threads) noexcept { return threads * (kJobsPerThread + 2); }

    /// Most tiles begun for each thread, about 2 MiB each: some wait for boxes while others go on.
    static constexpr int kJobsPerThread = 8;

private:
    struct Job {
        TileJob job;
        std::vector<voxel::BoxKey> came;
        bool running = true, queued = false;
    };
    [[nodiscard]] bool has_answer() const noexcept { return !m_results.empty() || m_failure || m_running == 0; }
    void run();
    void trace_tiles(TracerTools& tools);
    void go_on(TracerTools& tools, std::uint64_t ticket, Job& job);
    void block_came(const voxel::BoxKey& key, std::uint64_t ticket) noexcept override;

    const View& m_view;
    BlockManager& m_blocks;
    const std::size_t m_most_waiting, m_most_jobs;
    const int m_thread_count;
    std::mutex m_mutex;
    std::condition_variable m_work, m_room, m_done;
    std::deque<RenderTile> m_waiting;
    std::unordered_map<std::uint64_t, std::unique_ptr<Job>> m_jobs;
    std::vector<std::unique_ptr<Job>> m_idle;  ///< done, with megabytes of arrays for the next tile
    std::deque<std::uint64_t> m_ready;
    std::uint64_t m_next_ticket = 0;
    std::deque<TileResult> m_results;
    std::exception_ptr m_failure;
    int m_running = 0;
    bool m_closed = false;
    std::atomic<bool> m_cancelled{false};
    std::vector<std::thread> m_threads;
};

}  // namespace terravox
