#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "common/voxel/box.hpp"

namespace terravox::blocks {

/// The counters of a block manager, since it was made.
struct BlockStats {
    struct Level {
        std::uint64_t loaded = 0;
        std::uint64_t evicted = 0;
        std::uint64_t reloaded = 0;
        std::uint64_t bytes_loaded = 0;
    };
    std::array<Level, voxel::kMaxLevel + 1> levels{};
    /// Of find(): lookups that the readers' own caches could not answer.
    std::uint64_t hits = 0;
    std::uint64_t misses = 0;
    std::uint64_t waits = 0;  ///< times that a tile's rays had to wait for a box
    std::size_t bytes = 0;
    std::size_t peak_bytes = 0;
    std::size_t entries = 0;
    std::size_t holes = 0;
};

/// The memory that boxes take at one moment.
struct MemoryUse {
    std::size_t bytes = 0;           ///< of all boxes in memory
    std::size_t unseen_bytes = 0;    ///< of those that have arrived for a waiter and are unread
    std::size_t mean_box_bytes = 0;  ///< of the boxes loaded so far; a guess until there is one
};

}  // namespace terravox::blocks
