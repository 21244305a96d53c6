#pragma once

#include <cstdint>

#include "raytracer/processors/pool_member.hpp"

namespace terravox::processors {

/// Decides which bands of members that are not trusted are computed again, and which rows of them.
/// The choice is random, so that a member cannot predict it. Not thread-safe.
class CheckPolicy {
public:
    /// @param check_every  of that many bands of a member one is checked, and always its first; 0
    /// or less: none is
    /// @param seed         of the choice, which is the same for the same seed
    CheckPolicy(int check_every, std::uint64_t seed) noexcept
        : m_check_every(check_every), m_random(seed | 1) {}

    /// @return whether the band that the member has just answered is checked; this ends a request
    /// for a check
    [[nodiscard]] bool is_due(PoolMember& member) noexcept;
    /// @return the rows of a band that are computed again: as few as keep blocks of pixels whole,
    /// anywhere in it
    [[nodiscard]] tiles::RenderTile choose_rows(tiles::RenderTile band) noexcept;

private:
    [[nodiscard]] std::uint64_t next_random() noexcept;

    int m_check_every;
    std::uint64_t m_random;
};

}  // namespace terravox::processors
