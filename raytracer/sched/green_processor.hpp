#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "raytracer/sched/processor.hpp"
#include "raytracer/trace/tile_job.hpp"

namespace terravox {

/// Tiles on the stack of whoever waits for them: for programs without threads to spare, and for a window whose main thread traces between
/// two events. wait(most) traces for that long, a slice, and overruns it by a small wave of rays at most, or by the beams of a new tile: a few
/// milliseconds for tiles of up to 256 x 256 pixels. take() traces until there is an answer. A slice without any time still gets ahead, so
/// that nobody who asks again and again asks for ever.
///
/// wait() and take() are for one thread at a time; the others are thread-safe. submit() never blocks, since it may be the tracing
/// thread that calls it: who submits more than capacity() only makes the others' share smaller.
///
/// One mutex guards tiles submitted, jobs begun, jobs that are ready to go on, and results; it is not held while rays are traced. A job that
/// was paused is the first to go on, then come those whose boxes came, then new tiles. `m_change` wakes who waits with nothing to trace: a
/// tile, a box, or the end. The block manager calls with its own lock held: never call it under m_mutex.
class GreenProcessor final : public TileProcessor, private BlockListener {
public:
    /// @param view, blocks outlive the processor
    GreenProcessor(const View& view, BlockManager& blocks);
    ~GreenProcessor() override;
    [[nodiscard]] int capacity() const noexcept override { return kJobs + 1; }
    void submit(RenderTile tile) override;
    [[nodiscard]] bool wait(std::chrono::milliseconds most) override;
    std::optional<TileResult> take() override;
    void close() noexcept override;
    void cancel() noexcept override;

    /// Most tiles begun, about 2 MiB each: one is traced while others wait for boxes.
    static constexpr std::size_t kJobs = 4;

private:
    struct Job {
        TileJob job;
        std::vector<voxel::BoxKey> came;
        bool running = true, queued = false;
    };
    [[nodiscard]] bool may_begin() const noexcept { return !m_waiting.empty() && m_jobs.size() < kJobs; }
    [[nodiscard]] bool has_answer() const noexcept {
        return !m_results.empty() || m_failure || m_cancelled || (m_closed && m_waiting.empty() && m_jobs.empty());
    }
    [[nodiscard]] bool work_until(Halt::Clock::time_point end);
    void trace(std::unique_lock<std::mutex>& lock, const Halt& halt);
    void go_on(std::unique_lock<std::mutex>& lock, std::uint64_t ticket, Job& job, const Halt& halt);
    void block_came(const voxel::BoxKey& key, std::uint64_t ticket) noexcept override;

    BlockManager& m_blocks;
    TracerTools m_tools;
    std::mutex m_mutex;
    std::condition_variable m_change;
    std::deque<RenderTile> m_waiting;
    std::unordered_map<std::uint64_t, std::unique_ptr<Job>> m_jobs;
    std::vector<std::unique_ptr<Job>> m_idle;  ///< done, with megabytes of arrays for the next tile
    std::deque<std::uint64_t> m_ready;
    std::uint64_t m_next_ticket = 0;
    std::deque<TileResult> m_results;
    std::exception_ptr m_failure;
    bool m_closed = false;
    std::atomic<bool> m_cancelled{false};
};

}  // namespace terravox
