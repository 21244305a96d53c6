#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "raytracer/core/trace/tile_job.hpp"

namespace terravox::processors {

/// Tiles of a processor of this process: submitted, in progress, ready to continue as their boxes
/// were loaded, and their results. It locks nothing: the processor's mutex guards it, and is not
/// held while a job runs.
class TileJobs {
public:
    struct Job {
        trace::TileJob job;
        std::stop_source dropped;  ///< stopped when its result is not needed any more

    private:
        friend class TileJobs;
        tiles::RenderTile tile;
        std::vector<voxel::BoxKey> loaded;
        bool running = true;
        bool queued = false;
    };
    /// A job, and the ticket under which it waits for boxes (BlockManager::wait_for).
    struct Turn {
        std::uint64_t ticket;
        Job& job;
    };

    /// @param max maximum number of tiles in progress, about 2 MiB each
    explicit TileJobs(std::size_t max) : m_max(max) {}

    void submit(const tiles::RenderTile& tile) { m_waiting.push_back(tile); }
    [[nodiscard]] std::size_t waiting() const noexcept { return m_waiting.size(); }
    /// Whether next() has a job.
    [[nodiscard]] bool has_next() const noexcept {
        return !m_ready.empty() || (!m_waiting.empty() && m_jobs.size() < m_max);
    }
    [[nodiscard]] bool idle() const noexcept { return m_waiting.empty() && m_jobs.empty(); }
    /// The job to trace now: one that is ready, else one for a new tile.
    [[nodiscard]] Turn next();
    /// Puts aside a job that has run and is not finished.
    /// @param waits whether it waits for boxes; else it was interrupted, and continues next
    /// @return false: it was dropped meanwhile, and has ended
    [[nodiscard]] bool park(const Turn& turn, bool waits);
    /// Ends a job that is finished.
    /// @param result appended to the results
    void finish(const Turn& turn, tiles::TileResult&& result);
    /// @return whether a job can continue now; nullopt: no job has that ticket any more
    std::optional<bool> on_box_loaded(const voxel::BoxKey& key, std::uint64_t ticket);
    /// As TileProcessor::withdraw: a waiting tile never begins; one in progress ends without a
    /// result as soon as possible.
    /// @return the ticket of a job that this call has ended: it must be forgotten at the block
    /// manager
    std::optional<std::uint64_t> drop(const tiles::RenderTile& tile);
    void drop_waiting() noexcept { m_waiting.clear(); }
    [[nodiscard]] std::vector<tiles::RenderTile> take_back() {
        const auto waiting = std::exchange(m_waiting, {});
        return {waiting.begin(), waiting.end()};
    }
    [[nodiscard]] bool has_result() const noexcept { return !m_results.empty(); }
    [[nodiscard]] std::optional<tiles::TileResult> take();

private:
    void end(std::uint64_t ticket);

    const std::size_t m_max;
    std::deque<tiles::RenderTile> m_waiting;
    /// Jobs in progress, by ticket.
    std::unordered_map<std::uint64_t, std::unique_ptr<Job>> m_jobs;
    /// Finished jobs, whose large arrays are reused for the next tile.
    std::vector<std::unique_ptr<Job>> m_idle;
    std::deque<std::uint64_t> m_ready;
    std::uint64_t m_next_ticket = 0;
    std::deque<tiles::TileResult> m_results;
};

}  // namespace terravox::processors
