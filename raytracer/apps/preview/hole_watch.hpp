#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <set>

#include "raytracer/core/blocks/block_manager.hpp"

namespace terravox::preview {

/// Retries one of the boxes that a picture lacks, at growing intervals: a server may be back. Used
/// by one thread.
class HoleWatch final : public blocks::BlockListener {
public:
    using Clock = std::chrono::steady_clock;

    explicit HoleWatch(blocks::BlockManager& blocks) : m_blocks(blocks) {}
    ~HoleWatch() override { m_blocks.forget(*this); }
    HoleWatch(const HoleWatch&) = delete;
    HoleWatch& operator=(const HoleWatch&) = delete;

    /// To be called often: a box that has been loaded stays in memory until then. A retry forgets
    /// all holes.
    /// @param holes that the last picture met
    /// @param idle_since when that picture was finished; nullopt: a picture is being rendered, and
    /// nothing is retried
    /// @return whether one of the boxes has been loaded, so that the picture should be rendered
    /// again
    [[nodiscard]] bool look(const std::set<voxel::BoxKey>& holes,
                            std::optional<Clock::time_point> idle_since, Clock::time_point now);

    bool on_block_loaded(const voxel::BoxKey&, std::uint64_t) noexcept override {
        return m_loaded = true;
    }
    static constexpr std::chrono::seconds kFirst{10};
    static constexpr std::chrono::seconds kMax{640};

private:
    blocks::BlockManager& m_blocks;
    std::chrono::seconds m_wait = kFirst;
    Clock::time_point m_since;
    std::optional<voxel::BoxKey> m_requested;
    std::size_t m_turn = 0;
    std::atomic<bool> m_loaded{false};
};

}  // namespace terravox::preview
