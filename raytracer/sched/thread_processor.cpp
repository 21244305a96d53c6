#include "raytracer/sched/thread_processor.hpp"

namespace terravox {

ThreadProcessor::ThreadProcessor(const View& view, BlockManager& blocks, int threads)
    : m_view(view), m_blocks(blocks), m_most_waiting(static_cast<std::size_t>(threads) * 2), m_running(threads) {
    for (int i = 0; i < threads; ++i) m_threads.emplace_back([this] { run(); });
}

ThreadProcessor::~ThreadProcessor() {
    cancel();
    for (std::thread& t : m_threads) t.join();
}

void ThreadProcessor::submit(RenderTile tile) {
    std::unique_lock lock(m_mutex);
    m_room.wait(lock, [&] { return m_closed || m_waiting.size() < m_most_waiting; });
    if (m_closed) return;
    m_waiting.push_back(tile);
    m_work.notify_one();
}

std::optional<TileResult> ThreadProcessor::take() {
    std::unique_lock lock(m_mutex);
    m_done.wait(lock, [&] { return !m_results.empty() || m_failure || m_running == 0; });
    if (m_failure) std::rethrow_exception(m_failure);
    if (m_results.empty()) return std::nullopt;
    TileResult result = std::move(m_results.front());
    m_results.pop_front();
    return result;
}

void ThreadProcessor::close() noexcept {
    const std::lock_guard lock(m_mutex);
    m_closed = true;
    m_work.notify_all();
    m_room.notify_all();
}

void ThreadProcessor::cancel() noexcept {
    const std::lock_guard lock(m_mutex);
    m_closed = true;
    m_cancelled = true;
    m_waiting.clear();
    m_work.notify_all();
    m_room.notify_all();
}

void ThreadProcessor::run() {
    try {
        Shader shader(m_view, m_blocks);
        while (true) {
            RenderTile tile;
            {
                std::unique_lock lock(m_mutex);
                m_work.wait(lock, [&] { return m_closed || !m_waiting.empty(); });
                if (m_waiting.empty()) break;
                tile = m_waiting.front();
                m_waiting.pop_front();
                m_room.notify_one();
            }
            TileResult result;
            result.tile = tile;
            const std::uint64_t rays = shader.rays(), steps = shader.steps(), holes = shader.hole_rays();
            tile.each_pixel([&](int x, int y) {
                if (!m_cancelled.load(std::memory_order_relaxed)) result.samples.push_back(shader.pixel(x, y));
            });
            if (m_cancelled) break;
            result.rays = shader.rays() - rays, result.steps = shader.steps() - steps, result.hole_rays = shader.hole_rays() - holes;
            const std::lock_guard lock(m_mutex);
            m_results.push_back(std::move(result));
            m_done.notify_one();
        }
    } catch (...) {
        const std::lock_guard lock(m_mutex);
        if (!m_failure) m_failure = std::current_exception();
        m_closed = true;
        m_cancelled = true;
        m_work.notify_all();
        m_room.notify_all();
    }
    const std::lock_guard lock(m_mutex);
    --m_running;
    m_done.notify_all();
}

}  // namespace terravox
