#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/sched/farm.hpp"

namespace terravox {

struct CrewOptions {
    int threads = 1;     ///< of this process; 0: none
    bool green = false;  ///< the thread that coordinates traces, too, in slices
    FarmOptions farm;
    std::optional<std::chrono::milliseconds> give_up;  ///< how long to wait when nobody is left; none: for ever
};

/// Who renders the pictures of a world: threads of this process, workers elsewhere, or both.
class Crew {
public:
    /// @param source where workers may have boxes from @throws UsageError when nobody is left to render; Error when it cannot listen
    Crew(const CrewOptions& options, BlockManager& blocks, const BoxSource& source);
    ~Crew();

    /// Calls work(processor) with all of them as one. @param scene that the view was made of @return what work returns
    /// @throws what work throws
    void render(const Scene& scene, const View& view, const std::function<void(TileProcessor&)>& work);

    /// Whether others than threads of this process take part.
    [[nodiscard]] bool is_farm() const noexcept { return m_farm != nullptr; }
    /// Whether this process traces, beside what it makes again for checks.
    [[nodiscard]] bool traces_here() const noexcept { return m_options.threads > 0 || m_options.green; }

    /// Those who render now, or rendered the last picture.
    struct Hand {
        ProcessorPool::Status status;
        std::string peer;
        std::uint64_t memory_bytes = 0, received_bytes = 0;
    };
    [[nodiscard]] std::vector<Hand> hands() const;
    [[nodiscard]] ProcessorPool::Counts counts() const;
    /// hands() in lines for a person: a heading and one for each; empty where it is threads of this process alone.
    [[nodiscard]] std::vector<std::string> table() const;
    /// How many tiles there are, and how many are done, for who asks from outside.
    void set_progress(std::uint64_t tiles_done, std::uint64_t tiles) noexcept { m_tiles_done = tiles_done, m_tiles = tiles; }

private:
    [[nodiscard]] farm::Status told_status() const;

    const CrewOptions m_options;
    BlockManager& m_blocks;
    std::unique_ptr<Farm> m_farm;
    mutable std::mutex m_mutex;
    ProcessorPool* m_pool = nullptr;
    std::vector<Hand> m_last;
    ProcessorPool::Counts m_last_counts;
    std::atomic<std::uint64_t> m_tiles_done{0}, m_tiles{0};
    const std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
};

}  // namespace terravox
