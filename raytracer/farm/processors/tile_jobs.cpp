#include "raytracer/farm/processors/tile_jobs.hpp"

#include <algorithm>

namespace terravox::processors {

TileJobs::Turn TileJobs::next() {
    std::uint64_t ticket = 0;
    Job* job = nullptr;
    if (!m_ready.empty()) {
        ticket = m_ready.front();
        m_ready.pop_front();
        job = m_jobs.at(ticket).get();
    } else {
        if (m_idle.empty())
            m_idle.push_back(std::make_unique<Job>());
        ticket = m_next_ticket++;
        job = m_jobs.emplace(ticket, std::move(m_idle.back())).first->second.get();
        m_idle.pop_back();
        job->tile = m_waiting.front();
        m_waiting.pop_front();
        job->job.start(job->tile);
        if (job->dropped.stop_requested())
            job->dropped = std::stop_source();
    }
    job->running = true;
    job->queued = false;
    for (const voxel::BoxKey& key : job->loaded)
        job->job.on_box_loaded(key);
    job->loaded.clear();
    return {ticket, *job};
}

bool TileJobs::park(const Turn& turn, bool waits) {
    if (turn.job.dropped.stop_requested()) {
        end(turn.ticket);
        return false;
    }
    turn.job.running = false;
    if (waits && turn.job.loaded.empty())
        return true;
    turn.job.queued = true;
    if (waits)
        m_ready.push_back(turn.ticket);
    else
        m_ready.push_front(turn.ticket);
    return true;
}

void TileJobs::finish(const Turn& turn, tiles::TileResult&& result) {
    if (!turn.job.dropped.stop_requested())
        m_results.push_back(std::move(result));
    end(turn.ticket);
}

void TileJobs::end(std::uint64_t ticket) {
    const auto done = m_jobs.find(ticket);
    done->second->loaded.clear();
    m_idle.push_back(std::move(done->second));
    m_jobs.erase(done);
}

std::optional<bool> TileJobs::on_box_loaded(const voxel::BoxKey& key, std::uint64_t ticket) {
    const auto found = m_jobs.find(ticket);
    if (found == m_jobs.end())
        return std::nullopt;
    Job& job = *found->second;
    job.loaded.push_back(key);
    if (job.running || job.queued)
        return false;
    job.queued = true;
    m_ready.push_back(ticket);
    return true;
}

std::optional<std::uint64_t> TileJobs::drop(const tiles::RenderTile& tile) {
    if (const auto waiting = std::find(m_waiting.begin(), m_waiting.end(), tile);
        waiting != m_waiting.end()) {
        m_waiting.erase(waiting);
        return std::nullopt;
    }
    for (const auto& [known, job] : m_jobs) {
        if (job->tile != tile || job->dropped.stop_requested())
            continue;
        job->dropped.request_stop();
        if (job->running)
            return std::nullopt;  // it checks for that after each wave
        const std::uint64_t ticket = known;
        std::erase(m_ready, ticket);
        end(ticket);
        return ticket;
    }
    return std::nullopt;
}

std::optional<tiles::TileResult> TileJobs::take() {
    if (m_results.empty())
        return std::nullopt;
    tiles::TileResult result = std::move(m_results.front());
    m_results.pop_front();
    return result;
}

}  // namespace terravox::processors
