#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <stop_token>

#include "raytracer/farm/processors/processor.hpp"
#include "raytracer/farm/processors/tile_jobs.hpp"

namespace terravox::processors {

/// Traces tiles on the thread that waits for them: for programs without threads to spare, and for a
/// window whose main thread traces between two events. wait(timeout) traces for that time slice,
/// and overruns it by a small wave of rays at most, or by the beams of a new tile: a few
/// milliseconds for tiles of up to 256 x 256 pixels. take() traces until there is a result. A slice
/// of zero length still makes progress, so that polling terminates.
///
/// wait() and take() are for one thread at a time; the others are thread-safe. submit() never
/// blocks, since the tracing thread itself may call it; submitting more than capacity() only leaves
/// less for other processors.
///
/// One mutex guards the tiles and the failure; it is not held while rays are traced. An interrupted
/// job continues first, then jobs whose boxes were loaded, then new tiles. `m_change` wakes a
/// thread that waits with nothing to trace: for a tile, a box, or the end. The block manager calls
/// back with its own lock held: never call it under m_mutex.
class GreenProcessor final : public TileProcessor, private blocks::BlockListener {
public:
    /// @param view, blocks outlive the processor
    GreenProcessor(const shade::View& view, blocks::BlockManager& blocks);
    ~GreenProcessor() override;
    [[nodiscard]] int capacity() const noexcept override { return kJobs + 1; }
    void submit(tiles::RenderTile tile) override;
    [[nodiscard]] bool wait(std::chrono::milliseconds timeout) override {
        return work_until(thread::StopCondition::Clock::now() + timeout);
    }
    std::optional<tiles::TileResult> take() override;
    [[nodiscard]] std::vector<tiles::RenderTile> take_back() override;
    void withdraw(const tiles::RenderTile& tile) noexcept override;
    void close() noexcept override;
    void cancel() noexcept override;

    /// Maximum number of tiles in progress, about 2 MiB each: one is traced while others wait for
    /// boxes.
    static constexpr std::size_t kJobs = 4;

private:
    [[nodiscard]] bool has_answer() const noexcept {
        return m_jobs.has_result() || m_failure || m_stop.stop_requested() ||
               (m_closed && m_jobs.idle());
    }
    [[nodiscard]] bool work_until(thread::StopCondition::Clock::time_point end);
    void trace(std::unique_lock<std::mutex>& lock, thread::StopCondition::Clock::time_point end);
    void resume(std::unique_lock<std::mutex>& lock, const TileJobs::Turn& turn,
                thread::StopCondition::Clock::time_point end);
    bool on_block_loaded(const voxel::BoxKey& key, std::uint64_t ticket) noexcept override;

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
