#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <stop_token>

#include "raytracer/processors/processor.hpp"
#include "raytracer/processors/tile_jobs.hpp"

namespace terravox::processors {

/// Tiles on the stack of whoever waits for them: for programs without threads to spare, and for a
/// window whose main thread traces between two events. wait(most) traces for that long, a slice,
/// and overruns it by a small wave of rays at most, or by the beams of a new tile: a few
/// milliseconds for tiles of up to 256 x 256 pixels. take() traces until there is an answer. A
/// slice without any time still gets ahead, so that nobody who asks again and again asks for ever.
///
/// wait() and take() are for one thread at a time; the others are thread-safe. submit() never
/// blocks, since it may be the tracing thread that calls it: who submits more than capacity() only
/// makes the others' share smaller.
///
/// One mutex guards the tiles and what has failed; it is not held while rays are traced. A job that
/// was paused is the first to go on, then come those whose boxes came, then new tiles. `m_change`
/// wakes who waits with nothing to trace: a tile, a box, or the end. The block manager calls with
/// its own lock held: never call it under m_mutex.
class GreenProcessor final : public TileProcessor, private blocks::BlockListener {
public:
    /// @param view, blocks outlive the processor
    GreenProcessor(const shade::View& view, blocks::BlockManager& blocks);
    ~GreenProcessor() override;
    [[nodiscard]] int capacity() const noexcept override { return kJobs + 1; }
    void submit(tiles::RenderTile tile) override;
    [[nodiscard]] bool wait(std::chrono::milliseconds most) override;
    std::optional<tiles::TileResult> take() override;
    [[nodiscard]] std::vector<tiles::RenderTile> take_back() override;
    void withdraw(const tiles::RenderTile& tile) noexcept override;
    void close() noexcept override;
    void cancel() noexcept override;

    /// Most tiles begun, about 2 MiB each: one is traced while others wait for boxes.
    static constexpr std::size_t kJobs = 4;

private:
    [[nodiscard]] bool has_answer() const noexcept {
        return m_jobs.has_result() || m_failure || m_stop.stop_requested() ||
               (m_closed && m_jobs.idle());
    }
    [[nodiscard]] bool work_until(thread::StopCondition::Clock::time_point end);
    void trace(std::unique_lock<std::mutex>& lock, thread::StopCondition::Clock::time_point end);
    void go_on(std::unique_lock<std::mutex>& lock, const TileJobs::Turn& turn,
               thread::StopCondition::Clock::time_point end);
    bool block_came(const voxel::BoxKey& key, std::uint64_t ticket) noexcept override;

    blocks::BlockManager& m_blocks;
    trace::TracerTools m_tools;
    std::mutex m_mutex;
    std::condition_variable m_change;
    TileJobs m_jobs{kJobs};
    std::exception_ptr m_failure;
    bool m_closed = false;
    std::stop_source m_stop;
};

}  // namespace terravox::processors
