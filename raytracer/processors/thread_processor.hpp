#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#include "raytracer/processors/processor.hpp"
#include "raytracer/processors/tile_jobs.hpp"

namespace terravox::processors {

/// Tiles on threads of this process.
///
/// One mutex guards the tiles (at most so many wait) and what has failed. A thread takes a ready
/// job, else begins a tile, and traces without any lock until the job is finished or waits for
/// boxes; then it takes the next. `m_work` wakes threads, `m_room` wakes submitters, `m_done` wakes
/// takers (a result, a failure, or all threads ended). The block manager calls with its own lock
/// held: never call it under m_mutex.
class ThreadProcessor final : public TileProcessor, private blocks::BlockListener {
public:
    /// @param threads at least 1; @param view, blocks outlive the processor
    ThreadProcessor(const shade::View& view, blocks::BlockManager& blocks, int threads);
    ~ThreadProcessor() override;
    [[nodiscard]] int capacity() const noexcept override { return tiles_in_flight(m_thread_count); }
    void submit(tiles::RenderTile tile) override;
    [[nodiscard]] bool wait(std::chrono::milliseconds most) override;
    std::optional<tiles::TileResult> take() override;
    [[nodiscard]] std::vector<tiles::RenderTile> take_back() override;
    void withdraw(const tiles::RenderTile& tile) noexcept override;
    void close() noexcept override;
    void cancel() noexcept override;

    /// The capacity of a processor of so many threads.
    [[nodiscard]] static int tiles_in_flight(int threads) noexcept {
        return threads * (kJobsPerThread + 2);
    }

    /// Most tiles begun for each thread, about 2 MiB each: some wait for boxes while others go on.
    static constexpr int kJobsPerThread = 8;

private:
    [[nodiscard]] bool has_answer() const noexcept {
        return m_jobs.has_result() || m_failure || m_running == 0;
    }
    void run();
    void trace_tiles(trace::TracerTools& tools);
    void go_on(trace::TracerTools& tools, const TileJobs::Turn& turn);
    bool block_came(const voxel::BoxKey& key, std::uint64_t ticket) noexcept override;

    const shade::View& m_view;
    blocks::BlockManager& m_blocks;
    const std::size_t m_max_waiting;
    const int m_thread_count;
    std::mutex m_mutex;
    std::condition_variable m_work, m_room, m_done;
    TileJobs m_jobs;
    std::exception_ptr m_failure;
    int m_running = 0;
    bool m_closed = false;
    std::stop_source m_stop;
    std::vector<std::thread> m_threads;
};

}  // namespace terravox::processors
