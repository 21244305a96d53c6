#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <set>

#include "raytracer/blocks/block_manager.hpp"

namespace terravox::preview {

/// Asks again, now and then, for one of the boxes that a picture lacks, and more and more seldom: a
/// server may be back. Used by one thread.
class HoleWatch final : public blocks::BlockListener {
public:
    using Clock = std::chrono::steady_clock;

    explicit HoleWatch(blocks::BlockManager& blocks) : m_blocks(blocks) {}
    ~HoleWatch() override { m_blocks.forget(*this); }
    HoleWatch(const HoleWatch&) = delete;
    HoleWatch& operator=(const HoleWatch&) = delete;

    /// To be called often: a box that has come stays in memory until then.
    /// @param holes that the last picture met @param idle_since when it was finished; nullopt: one
    /// is being rendered. All holes are forgotten when
    ///        one is asked for, which is never done meanwhile
    /// @return one of them has come: the picture can be begun anew
    [[nodiscard]] bool look(const std::set<voxel::BoxKey>& holes,
                            std::optional<Clock::time_point> idle_since, Clock::time_point now);

    bool block_came(const voxel::BoxKey&, std::uint64_t) noexcept override { return m_came = true; }

    static constexpr std::chrono::seconds kFirst{10}, kMax{640};

private:
    blocks::BlockManager& m_blocks;
    std::chrono::seconds m_wait = kFirst;
    Clock::time_point m_since;
    std::optional<voxel::BoxKey> m_asked;
    std::size_t m_turn = 0;
    std::atomic<bool> m_came{false};
};

}  // namespace terravox::preview
