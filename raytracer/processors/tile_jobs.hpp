#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "raytracer/trace/tile_job.hpp"

namespace terravox::processors {

/// Tiles of a processor of this process: submitted, begun, ready to go on since boxes came, and
/// their results. It locks nothing: the processor's mutex guards it, and is not held while a job
/// runs.
class TileJobs {
public:
    struct Job {
        trace::TileJob job;
        std::stop_source dropped;  ///< stopped when its result is not needed any more

    private:
        friend class TileJobs;
        tiles::RenderTile tile;
        std::vector<voxel::BoxKey> came;
        bool running = true, queued = false;
    };
    /// A job, and the number that boxes it waits for are asked under.
    struct Turn {
        std::uint64_t ticket;
        Job& job;
    };

    /// @param most begun at once, about 2 MiB each
    explicit TileJobs(std::size_t most) : m_max(most) {}

    void submit(const tiles::RenderTile& tile) { m_waiting.push_back(tile); }
    [[nodiscard]] std::size_t waiting() const noexcept { return m_waiting.size(); }
    /// Whether next() has something.
    [[nodiscard]] bool can_go_on() const noexcept {
        return !m_ready.empty() || (!m_waiting.empty() && m_jobs.size() < m_max);
    }
    [[nodiscard]] bool idle() const noexcept { return m_waiting.empty() && m_jobs.empty(); }
    /// What to trace now: a job that is ready, else one that begins. @param wave_rays of one that
    /// begins
    [[nodiscard]] Turn next(std::size_t wave_rays);
    /// The job has run, and is not finished. @param waits for boxes; else it was interrupted, and
    /// is the next to go on
    /// @return false: it was dropped meanwhile, and has ended
    [[nodiscard]] bool rest(const Turn& turn, bool waits);
    /// The job is finished: @param result becomes the next of the results
    void finish(const Turn& turn, tiles::TileResult&& result);
    /// @return whether a job can go on by this; nullopt: none has that ticket any more
    std::optional<bool> box_came(const voxel::BoxKey& key, std::uint64_t ticket);
    /// As TileProcessor::withdraw: waiting, it never begins; begun, it ends without a result as
    /// soon as it can.
    /// @return the ticket of a job that has ended by this: nothing must come for it any more
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
    std::unordered_map<std::uint64_t, std::unique_ptr<Job>> m_jobs;  ///< begun, by ticket
    std::vector<std::unique_ptr<Job>> m_idle;  ///< done, with megabytes of arrays for the next tile
    std::deque<std::uint64_t> m_ready;
    std::uint64_t m_next_ticket = 0;
    std::deque<tiles::TileResult> m_results;
};

}  // namespace terravox::processors
