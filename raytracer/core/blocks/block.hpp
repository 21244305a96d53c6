#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"

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

/// A box as the walker meets it. A hole is a box that could not be made or fetched: it is shown and
/// counted, never treated as air.
struct Block {
    std::shared_ptr<const voxel::Box> box;  ///< nullptr: air, or a hole
    bool hole = false;
    /// Bricks whose `first` is less than this are full of equal voxels: see packed().
    std::uint32_t shared_attrs = 0;
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        return kOverhead_bytes + (box ? box->memory_bytes() : 0);
    }
    /// Bytes of an entry and its place in maps and lists.
    static constexpr std::size_t kOverhead_bytes = 256;
};
/// Keeps its box in memory while it exists: the box is not evicted.
using BlockPin = std::shared_ptr<const Block>;

/// Notified when boxes that it waits for have arrived.
class BlockListener {
public:
    virtual ~BlockListener() = default;
    /// Called once for each wait, from any thread and with the manager's lock held: it must be
    /// short and must not call the manager.
    /// @return whether the box will be read by the waiting side; it stays in memory until then
    virtual bool on_block_loaded(const voxel::BoxKey& key, std::uint64_t ticket) noexcept = 0;
};

/// A box to be walked, in less memory where half of it can be saved: bricks that are full of equal
/// voxels, as in deep water, share their attributes. Then it has the same voxels, but its blob is
/// none in the box format, in which nothing is shared.
/// @param box a box of the box format, or nullptr
[[nodiscard]] Block packed(std::shared_ptr<const voxel::Box> box);

}  // namespace terravox::blocks
