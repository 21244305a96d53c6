#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "raytracer/sched/processor.hpp"
#include "raytracer/shade/shader.hpp"

namespace terravox {

/// Tiles on threads of this process.
///
/// Two queues guarded by one mutex: tiles waiting, bounded so that a coordinator with several processors does not hand all work to
/// one, and results waiting to be taken. Each thread takes a tile, traces it without any lock, and puts the result. `m_work` wakes
/// threads (a tile came, or the end), `m_room` wakes submitters, `m_done` wakes takers (a result, a failure, or all threads ended).
class ThreadProcessor final : public TileProcessor {
public:
    /// @param threads at least 1; @param view, blocks outlive the processor
    ThreadProcessor(const View& view, BlockManager& blocks, int threads);
    ~ThreadProcessor() override;
    void submit(RenderTile tile) override;
    std::optional<TileResult> take() override;
    void close() noexcept override;
    void cancel() noexcept override;

private:
    void run();
    const View& m_view;
    BlockManager& m_blocks;
    const std::size_t m_most_waiting;
    std::mutex m_mutex;
    std::condition_variable m_work, m_room, m_done;
    std::deque<RenderTile> m_waiting;
    std::deque<TileResult> m_results;
    std::exception_ptr m_failure;
    int m_running = 0;
    bool m_closed = false;
    std::atomic<bool> m_cancelled{false};
    std::vector<std::thread> m_threads;
};

}  // namespace terravox
