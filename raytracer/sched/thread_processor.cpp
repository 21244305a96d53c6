#include "raytracer/sched/thread_processor.hpp"

#include <algorithm>

namespace terravox {
namespace {

// Tiles under way lie beside the boxes in memory: of many threads they must not take more than those.
std::size_t most_jobs(std::size_t limit_bytes, std::size_t threads) noexcept {
    constexpr std::size_t kShare = std::size_t{8} << 20;
    return std::clamp(limit_bytes / kShare, threads, threads * ThreadProcessor::kJobsPerThread);
}

}  // namespace

ThreadProcessor::ThreadProcessor(const View& view, BlockManager& blocks, int threads)
    : m_view(view), m_blocks(blocks), m_most_waiting(static_cast<std::size_t>(tiles_in_flight(threads))),
      m_most_jobs(most_jobs(blocks.limit_bytes(), static_cast<std::size_t>(threads))), m_thread_count(threads), m_running(threads) {
    for (int i = 0; i < threads; ++i) m_threads.emplace_back([this] { run(); });
}

ThreadProcessor::~ThreadProcessor() {
    cancel();
    for (std::thread& t : m_threads) t.join();
    m_blocks.forget(*this);
}

void ThreadProcessor::submit(RenderTile tile) {
    std::unique_lock lock(m_mutex);
    m_room.wait(lock, [&] { return m_closed || m_waiting.size() < m_most_waiting; });
    if (m_closed) return;
    m_waiting.push_back(tile);
    m_work.notify_one();
}

bool ThreadProcessor::wait(std::chrono::milliseconds most) {
    std::unique_lock lock(m_mutex);
    return m_done.wait_for(lock, most, [&] { return has_answer(); });
}

std::optional<TileResult> ThreadProcessor::take() {
    std::unique_lock lock(m_mutex);
    m_done.wait(lock, [&] { return has_answer(); });
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

void ThreadProcessor::block_came(const voxel::BoxKey& key, std::uint64_t ticket) noexcept {
    const std::lock_guard lock(m_mutex);
    const auto found = m_jobs.find(ticket);
    if (found == m_jobs.end()) return;
    Job& job = *found->second;
    job.came.push_back(key);
    if (job.running || job.queued) return;
    job.queued = true;
    m_ready.push_back(ticket);
    m_work.notify_one();
}

void ThreadProcessor::run() {
    try {
        TracerTools tools(m_view, m_blocks, m_blocks.limit_bytes() / 8 / static_cast<std::size_t>(m_thread_count));
        trace_tiles(tools);
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

void ThreadProcessor::trace_tiles(TracerTools& tools) {
    std::unique_lock lock(m_mutex);
    while (true) {
        const auto may_begin = [&] { return !m_waiting.empty() && m_jobs.size() < m_most_jobs; };
        m_work.wait(lock, [&] { return m_cancelled || !m_ready.empty() || may_begin() || (m_closed && m_waiting.empty() && m_jobs.empty()); });
        if (m_cancelled || (m_ready.empty() && !may_begin())) return;
        std::uint64_t ticket = 0;
        Job* job = nullptr;
        if (!m_ready.empty()) {
            ticket = m_ready.front();
            m_ready.pop_front();
            job = m_jobs.at(ticket).get();
            job->queued = false, job->running = true;
        } else {
            ticket = m_next_ticket++;
            if (m_idle.empty()) m_idle.push_back(std::make_unique<Job>());
            job = m_jobs.emplace(ticket, std::move(m_idle.back())).first->second.get();
            m_idle.pop_back();
            job->running = true, job->queued = false;
            job->job.start(m_waiting.front());
            m_waiting.pop_front();
            m_room.notify_one();
        }
        for (const voxel::BoxKey& key : job->came) job->job.box_came(key);
        job->came.clear();
        lock.unlock();
        go_on(tools, ticket, *job);
        lock.lock();
    }
}

void ThreadProcessor::go_on(TracerTools& tools, std::uint64_t ticket, Job& job) {
    const bool finished = job.job.run(tools, m_cancelled);
    if (m_cancelled) return;
    if (finished) {
        TileResult result = job.job.take_result();
        const std::lock_guard lock(m_mutex);
        const auto done = m_jobs.find(ticket);
        done->second->came.clear();
        m_idle.push_back(std::move(done->second));
        m_jobs.erase(done);
        m_results.push_back(std::move(result));
        m_done.notify_one();
        m_work.notify_all();  // room for another job; or the last has ended
        return;
    }
    const std::vector<voxel::BoxKey> missing = job.job.take_missing();
    {
        const std::lock_guard lock(m_mutex);
        job.running = false;
        if (!job.came.empty()) {
            job.queued = true;
            m_ready.push_back(ticket);
            m_work.notify_one();
        }
    }
    // From here on another thread may have the job.
    for (const voxel::BoxKey& key : missing) m_blocks.wait_for(key, *this, ticket);
}

}  // namespace terravox
