#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#include "raytracer/farm/processors/processor.hpp"
#include "raytracer/farm/processors/tile_jobs.hpp"

namespace terravox::processors {

/// Traces tiles on threads of this process.
///
/// One mutex guards the tiles (a bounded number) and the failure. A thread takes a ready job, else
/// begins a tile, and traces without any lock until the job is finished or waits for boxes; then it
/// takes the next. `m_work` wakes threads, `m_room` wakes callers of submit(), `m_done` wakes
/// callers of take() (for a result, a failure, or the end of all threads). The block manager calls
/// back with its own lock held: never call it under m_mutex.
class ThreadProcessor final : public TileProcessor, private blocks::BlockListener {
public:
    /// @param view, blocks outlive the processor
    /// @param threads at least 1
    ThreadProcessor(const shade::View& view, blocks::BlockManager& blocks, int threads);
    ~ThreadProcessor() override;
    [[nodiscard]] int capacity() const noexcept override { return tiles_in_flight(m_thread_count); }
    void submit(tiles::RenderTile tile) override;
    [[nodiscard]] bool wait(std::chrono::milliseconds timeout) override;
    std::optional<tiles::TileResult> take() override;
    [[nodiscard]] std::vector<tiles::RenderTile> take_back() override;
    void withdraw(const tiles::RenderTile& tile) noexcept override;
    void close() noexcept override;
    void cancel() noexcept override;

    /// The capacity of a processor with this many threads.
    [[nodiscard]] static int tiles_in_flight(int threads) noexcept {
        return threads * (kJobsPerThread + 2);
    }

    /// Maximum number of tiles in progress per thread, about 2 MiB each: some wait for boxes while
    /// others are traced.
    static constexpr int kJobsPerThread = 8;

private:
    [[nodiscard]] bool has_answer() const noexcept {
        return m_jobs.has_result() || m_failure || m_running == 0;
    }
    void run();
    void trace_tiles(trace::TracerTools& tools);
    void resume(trace::TracerTools& tools, const TileJobs::Turn& turn);
    bool on_block_loaded(const voxel::BoxKey& key, std::uint64_t ticket) noexcept override;

    const shade::View& m_view;
    blocks::BlockManager& m_blocks;
    const std::size_t m_max_waiting;
    const int m_thread_count;
    std::mutex m_mutex;
    std::condition_variable m_work;
    std::condition_variable m_room;
    std::condition_variable m_done;
    TileJobs m_jobs;
    std::exception_ptr m_failure;
    int m_running = 0;
    bool m_closed = false;
    std::stop_source m_stop;
    std::vector<std::thread> m_threads;
};

}  // namespace terravox::processors
