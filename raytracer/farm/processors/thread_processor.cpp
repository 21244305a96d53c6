#include "raytracer/farm/processors/thread_processor.hpp"

#include <algorithm>

#include "common/thread/start_threads.hpp"

namespace terravox::processors {
namespace {

// Tiles in progress take memory in addition to the boxes: with many threads they must not take more
// than the boxes.
std::size_t max_jobs(std::size_t limit_bytes, std::size_t threads) noexcept {
    constexpr std::size_t kShare = std::size_t{8} << 20;
    return std::clamp(limit_bytes / kShare, threads, threads * ThreadProcessor::kJobsPerThread);
}

}  // namespace

ThreadProcessor::ThreadProcessor(const shade::View& view, blocks::BlockManager& blocks, int threads)
    : m_view(view),
      m_blocks(blocks),
      m_max_waiting(static_cast<std::size_t>(tiles_in_flight(threads))),
      m_thread_count(threads),
      m_jobs(max_jobs(blocks.limit_bytes(), static_cast<std::size_t>(threads))),
      m_running(threads) {
    thread::start_threads(
        m_threads, static_cast<std::size_t>(threads), [this] { run(); }, [this] { cancel(); });
}

ThreadProcessor::~ThreadProcessor() {
    cancel();
    for (std::thread& t : m_threads)
        t.join();
    m_blocks.forget(*this);
}

void ThreadProcessor::submit(tiles::RenderTile tile) {
    std::unique_lock lock(m_mutex);
    m_room.wait(lock, [&] { return m_closed || m_jobs.waiting() < m_max_waiting; });
    if (m_closed)
        return;
    m_jobs.submit(tile);
    m_work.notify_one();
}

bool ThreadProcessor::wait(std::chrono::milliseconds timeout) {
    std::unique_lock lock(m_mutex);
    return m_done.wait_for(lock, timeout, [&] { return has_answer(); });
}

std::optional<tiles::TileResult> ThreadProcessor::take() {
    std::unique_lock lock(m_mutex);
    m_done.wait(lock, [&] { return has_answer(); });
    if (m_failure)
        std::rethrow_exception(m_failure);
    return m_jobs.take();
}

std::vector<tiles::RenderTile> ThreadProcessor::take_back() {
    const std::lock_guard lock(m_mutex);
    m_work.notify_all();
    m_room.notify_all();
    return m_jobs.take_back();
}

void ThreadProcessor::withdraw(const tiles::RenderTile& tile) noexcept {
    std::optional<std::uint64_t> ended;
    {
        const std::lock_guard lock(m_mutex);
        ended = m_jobs.drop(tile);
        m_work.notify_all();  // room for another job; or none is left
        m_room.notify_all();
    }
    if (ended)
        m_blocks.forget(*this, *ended);
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
    m_stop.request_stop();
    m_jobs.drop_waiting();
    m_work.notify_all();
    m_room.notify_all();
}

bool ThreadProcessor::on_block_loaded(const voxel::BoxKey& key, std::uint64_t ticket) noexcept {
    const std::lock_guard lock(m_mutex);
    const auto goes_on = m_jobs.on_box_loaded(key, ticket);
    if (goes_on.value_or(false))
        m_work.notify_one();
    return goes_on.has_value();
}

void ThreadProcessor::run() {
    try {
        trace::TracerTools tools(
            m_view, m_blocks,
            m_blocks.limit_bytes() / 8 / static_cast<std::size_t>(m_thread_count));
        trace_tiles(tools);
    } catch (...) {
        const std::lock_guard lock(m_mutex);
        if (!m_failure)
            m_failure = std::current_exception();
        m_closed = true;
        m_stop.request_stop();
        m_work.notify_all();
        m_room.notify_all();
    }
    const std::lock_guard lock(m_mutex);
    --m_running;
    m_done.notify_all();
}

void ThreadProcessor::trace_tiles(trace::TracerTools& tools) {
    std::unique_lock lock(m_mutex);
    while (true) {
        m_work.wait(lock, [&] {
            return m_stop.stop_requested() || m_jobs.has_next() || (m_closed && m_jobs.idle());
        });
        if (m_stop.stop_requested() || !m_jobs.has_next())
            return;
        const TileJobs::Turn turn = m_jobs.next();
        m_room.notify_one();
        lock.unlock();
        resume(tools, turn);
        lock.lock();
    }
}

void ThreadProcessor::resume(trace::TracerTools& tools, const TileJobs::Turn& turn) {
    const bool finished = turn.job.job.run(
        tools, thread::StopCondition(m_stop.get_token(), turn.job.dropped.get_token()));
    if (m_stop.stop_requested())
        return;
    if (finished) {
        tiles::TileResult result = turn.job.job.take_result();
        const std::lock_guard lock(m_mutex);
        m_jobs.finish(turn, std::move(result));
        m_done.notify_one();
        m_work.notify_all();  // room for another job; or the last has ended
        return;
    }
    const std::vector<voxel::BoxKey> missing = turn.job.job.take_missing();
    bool stays = false;
    {
        const std::lock_guard lock(m_mutex);
        stays = m_jobs.park(turn, turn.job.job.waits());
        m_work.notify_all();
    }
    // From here on another thread may have the job.
    if (!stays)
        return m_blocks.forget(*this, turn.ticket);
    for (const voxel::BoxKey& key : missing)
        m_blocks.wait_for(key, *this, turn.ticket);
}

}  // namespace terravox::processors
