#include "raytracer/farm/processors/green_processor.hpp"

namespace terravox::processors {

GreenProcessor::GreenProcessor(const shade::View& view, blocks::BlockManager& blocks)
    : m_blocks(blocks), m_tools(view, blocks, blocks.limit_bytes() / 8) {}

GreenProcessor::~GreenProcessor() {
    cancel();
    m_blocks.forget(*this);
}

void GreenProcessor::submit(tiles::RenderTile tile) {
    const std::lock_guard lock(m_mutex);
    if (m_closed)
        return;
    m_jobs.submit(tile);
    m_change.notify_all();
}

std::optional<tiles::TileResult> GreenProcessor::take() {
    (void)work_until(thread::StopCondition::Clock::time_point::max());
    const std::lock_guard lock(m_mutex);
    if (m_failure)
        std::rethrow_exception(m_failure);
    return m_jobs.take();
}

std::vector<tiles::RenderTile> GreenProcessor::take_back() {
    const std::lock_guard lock(m_mutex);
    m_change.notify_all();
    return m_jobs.take_back();
}

void GreenProcessor::withdraw(const tiles::RenderTile& tile) noexcept {
    std::optional<std::uint64_t> ended;
    {
        const std::lock_guard lock(m_mutex);
        ended = m_jobs.drop(tile);
        m_change.notify_all();
    }
    if (ended)
        m_blocks.forget(*this, *ended);
}

void GreenProcessor::close() noexcept {
    const std::lock_guard lock(m_mutex);
    m_closed = true;
    m_change.notify_all();
}

void GreenProcessor::cancel() noexcept {
    const std::lock_guard lock(m_mutex);
    m_closed = true;
    m_stop.request_stop();
    m_jobs.drop_waiting();
    m_change.notify_all();
}

bool GreenProcessor::on_block_loaded(const voxel::BoxKey& key, std::uint64_t ticket) noexcept {
    const std::lock_guard lock(m_mutex);
    const auto goes_on = m_jobs.on_box_loaded(key, ticket);
    if (goes_on.value_or(false))
        m_change.notify_all();
    return goes_on.has_value();
}

bool GreenProcessor::work_until(thread::StopCondition::Clock::time_point end) {
    std::unique_lock lock(m_mutex);
    bool first = true;
    while (!has_answer()) {
        if (m_jobs.has_next()) {
            if (!first && thread::StopCondition::Clock::now() >= end)
                return false;
            trace(lock, end);
            first = false;
            continue;
        }
        const auto something = [&] { return has_answer() || m_jobs.has_next(); };
        if (end == thread::StopCondition::Clock::time_point::max())
            m_change.wait(lock, something);
        else if (!m_change.wait_until(lock, end, something))
            return false;
    }
    return true;
}

void GreenProcessor::trace(std::unique_lock<std::mutex>& lock,
                           thread::StopCondition::Clock::time_point end) {
    try {
        resume(lock, m_jobs.next(), end);
    } catch (...) {
        if (!lock.owns_lock())
            lock.lock();
        m_failure = std::current_exception();
        m_closed = true;
        m_stop.request_stop();
        m_jobs.drop_waiting();
    }
}

void GreenProcessor::resume(std::unique_lock<std::mutex>& lock, const TileJobs::Turn& turn,
                            thread::StopCondition::Clock::time_point end) {
    lock.unlock();
    const bool finished = turn.job.job.run(
        m_tools, thread::StopCondition(m_stop.get_token(), turn.job.dropped.get_token(), end));
    std::optional<tiles::TileResult> result;
    if (finished)
        result = turn.job.job.take_result();
    const std::vector<voxel::BoxKey> missing = turn.job.job.take_missing();
    lock.lock();
    if (m_stop.stop_requested())
        return;
    if (finished) {
        m_jobs.finish(turn, std::move(*result));
        return;
    }
    const bool stays = m_jobs.park(turn, turn.job.job.waits());
    lock.unlock();
    if (stays) {
        for (const voxel::BoxKey& key : missing)
            m_blocks.wait_for(key, *this, turn.ticket);
    } else {
        m_blocks.forget(*this, turn.ticket);
    }
    lock.lock();
}

}  // namespace terravox::processors
