#include "raytracer/sched/green_processor.hpp"

namespace terravox {
namespace {

// A wave of the usual size takes up to 8 ms, one of these up to 3 ms, and the picture no longer.
constexpr std::size_t kWaveRays = TileJob::kWaveRays / 4;

}  // namespace

GreenProcessor::GreenProcessor(const View& view, BlockManager& blocks) : m_blocks(blocks), m_tools(view, blocks, blocks.limit_bytes() / 8) {}

GreenProcessor::~GreenProcessor() {
    cancel();
    m_blocks.forget(*this);
}

void GreenProcessor::submit(RenderTile tile) {
    const std::lock_guard lock(m_mutex);
    if (m_closed) return;
    m_waiting.push_back(tile);
    m_change.notify_all();
}

bool GreenProcessor::wait(std::chrono::milliseconds most) { return work_until(Halt::Clock::now() + most); }

std::optional<TileResult> GreenProcessor::take() {
    (void)work_until(Halt::Clock::time_point::max());
    const std::lock_guard lock(m_mutex);
    if (m_failure) std::rethrow_exception(m_failure);
    if (m_results.empty()) return std::nullopt;
    TileResult result = std::move(m_results.front());
    m_results.pop_front();
    return result;
}

void GreenProcessor::close() noexcept {
    const std::lock_guard lock(m_mutex);
    m_closed = true;
    m_change.notify_all();
}

void GreenProcessor::cancel() noexcept {
    const std::lock_guard lock(m_mutex);
    m_closed = true;
    m_cancelled = true;
    m_waiting.clear();
    m_change.notify_all();
}

void GreenProcessor::block_came(const voxel::BoxKey& key, std::uint64_t ticket) noexcept {
    const std::lock_guard lock(m_mutex);
    const auto found = m_jobs.find(ticket);
    if (found == m_jobs.end()) return;
    Job& job = *found->second;
    job.came.push_back(key);
    if (job.running || job.queued) return;
    job.queued = true;
    m_ready.push_back(ticket);
    m_change.notify_all();
}

bool GreenProcessor::work_until(Halt::Clock::time_point end) {
    const Halt halt(m_cancelled, end);
    std::unique_lock lock(m_mutex);
    bool first = true;
    while (!has_answer()) {
        if (!m_ready.empty() || may_begin()) {
            if (!first && halt.asked()) return false;
            trace(lock, halt);
            first = false;
            continue;
        }
        const auto something = [&] { return has_answer() || !m_ready.empty() || may_begin(); };
        if (end == Halt::Clock::time_point::max()) m_change.wait(lock, something);
        else if (!m_change.wait_until(lock, end, something)) return false;
    }
    return true;
}

void GreenProcessor::trace(std::unique_lock<std::mutex>& lock, const Halt& halt) {
    try {
        std::uint64_t ticket = 0;
        Job* job = nullptr;
        if (!m_ready.empty()) {
            ticket = m_ready.front();
            m_ready.pop_front();
            job = m_jobs.at(ticket).get();
            job->queued = false, job->running = true;
        } else {
            if (m_idle.empty()) m_idle.push_back(std::make_unique<Job>());
            ticket = m_next_ticket++;
            job = m_jobs.emplace(ticket, std::move(m_idle.back())).first->second.get();
            m_idle.pop_back();
            job->running = true, job->queued = false;
            job->job.start(m_waiting.front(), kWaveRays);
            m_waiting.pop_front();
        }
        for (const voxel::BoxKey& key : job->came) job->job.box_came(key);
        job->came.clear();
        go_on(lock, ticket, *job, halt);
    } catch (...) {
        if (!lock.owns_lock()) lock.lock();
        m_failure = std::current_exception();
        m_closed = true;
        m_cancelled = true;
        m_waiting.clear();
    }
}

void GreenProcessor::go_on(std::unique_lock<std::mutex>& lock, std::uint64_t ticket, Job& job, const Halt& halt) {
    lock.unlock();
    const bool finished = job.job.run(m_tools, halt);
    std::optional<TileResult> result;
    if (finished) result = job.job.take_result();
    const std::vector<voxel::BoxKey> missing = job.job.take_missing();
    lock.lock();
    if (m_cancelled) return;
    if (finished) {
        const auto done = m_jobs.find(ticket);
        job.came.clear();
        m_idle.push_back(std::move(done->second));
        m_jobs.erase(done);
        m_results.push_back(std::move(*result));
        return;
    }
    job.running = false;
    if (!job.job.waits() || !job.came.empty()) {
        job.queued = true;
        m_ready.push_front(ticket);
    }
    lock.unlock();
    for (const voxel::BoxKey& key : missing) m_blocks.wait_for(key, *this, ticket);
    lock.lock();
}

}  // namespace terravox
