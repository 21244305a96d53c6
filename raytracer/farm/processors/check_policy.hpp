#pragma once

#include <cstdint>

#include "raytracer/farm/processors/pool_member.hpp"

namespace terravox::processors {

/// Decides which bands of untrusted members are recomputed, and which of their rows.
/// The choice is random, so that a member cannot predict it. Not thread-safe.
class CheckPolicy {
public:
    /// @param check_every  one of this many bands of a member is checked, and always its first; 0
    /// or less: none
    /// @param seed         seed of the random choice
    CheckPolicy(int check_every, std::uint64_t seed) noexcept
        : m_check_every(check_every), m_random(seed | 1) {}

    /// @return whether the band that the member has just answered is checked; this ends a request
    /// for a check
    [[nodiscard]] bool is_due(PoolMember& member) noexcept;
    /// @return the rows of a band to recompute: the smallest number that keeps blocks of pixels
    /// whole, at a random position
    [[nodiscard]] tiles::RenderTile choose_rows(tiles::RenderTile band) noexcept;

private:
    [[nodiscard]] std::uint64_t next_random() noexcept;

    int m_check_every;
    std::uint64_t m_random;
};

}  // namespace terravox::processors
