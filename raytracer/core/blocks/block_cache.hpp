#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "common/voxel/box.hpp"
#include "raytracer/core/blocks/block.hpp"

namespace terravox::blocks {

/// The boxes in memory, the waits for boxes that are not, and the order of eviction. Over its limit
/// it evicts the least recently used boxes, but never one that is pinned, that a thread in get()
/// waits for, or that is unseen: arrived for a waiter which has not read it yet. It loads nothing
/// and wakes no thread. Not thread-safe: the block manager uses it under its lock.
class BlockCache {
public:
    struct Wait {
        BlockListener* listener;
        std::uint64_t ticket;
    };
    /// What is known of one box. References to it are valid until it is removed.
    struct Entry {
        BlockPin block;                            ///< nullptr while it is queued or being loaded
        std::list<voxel::BoxKey>::iterator place;  ///< in m_order, only with a block
        std::vector<Wait> waits;
        bool loading = false;
        bool wanted = false;  ///< queued to be loaded, with a waiter
        int getters = 0;      ///< threads in get(); the entry is kept while there are any
        bool unseen = false;  ///< arrived for a waiter that has not read it yet
    };

    explicit BlockCache(std::size_t limit_bytes) noexcept : m_limit_bytes(limit_bytes) {}

    [[nodiscard]] std::size_t limit_bytes() const noexcept { return m_limit_bytes; }
    /// @return nullptr when nothing is known of the box; with an entry it may yet have no block
    [[nodiscard]] Entry* find(const voxel::BoxKey& key) {
        const auto found = m_entries.find(key);
        return found == m_entries.end() ? nullptr : &found->second;
    }
    /// @return the entry of the box, which is made when there is none
    [[nodiscard]] Entry& make_entry(const voxel::BoxKey& key) { return m_entries[key]; }
    [[nodiscard]] bool contains(const voxel::BoxKey& key) const { return m_entries.contains(key); }

    /// Makes a box the most recently used one, and no longer unseen.
    /// @param entry one with a block
    /// @return whether it was unseen: loaders that pause for unseen boxes may have room now
    [[nodiscard]] bool touch(Entry& entry) {
        const bool was_unseen = entry.unseen;
        if (was_unseen) {
            entry.unseen = false;
            m_unseen_bytes -= entry.block->memory_bytes();
        }
        m_order.splice(m_order.begin(), m_order, entry.place);
        return was_unseen;
    }
    /// Stores a box that was not in memory, as the most recently used one. Evicts nothing.
    Entry& insert(const voxel::BoxKey& key, BlockPin block);
    /// Keeps a box in memory until the next touch().
    /// @param entry one with a block, and not unseen
    void set_unseen(Entry& entry) noexcept;
    /// Evicts boxes until the others are within the limit, or as far as that is possible.
    /// @param evicted the blocks are appended, so that the caller can free them without its lock
    void evict(std::vector<BlockPin>& evicted);
    /// Removes a box that is in memory and not unseen.
    void remove(const voxel::BoxKey& key);
    /// Removes the listener's waits with this ticket, or all of them, and the entries that nothing
    /// needs then. Unseen boxes are touched: they may have arrived for one of these waits.
    /// @return whether a box was unseen, see touch()
    [[nodiscard]] bool remove_waits(const BlockListener& listener,
                                    std::optional<std::uint64_t> ticket);

    void count_hit() noexcept { ++m_stats.hits; }
    void count_miss() noexcept { ++m_stats.misses; }
    void count_wait() noexcept { ++m_stats.waits; }
    /// All counters but that of holes.
    [[nodiscard]] BlockStats stats() const;
    [[nodiscard]] MemoryUse memory_use() const noexcept;

private:
    const std::size_t m_limit_bytes;
    std::unordered_map<voxel::BoxKey, Entry, voxel::BoxKeyHash> m_entries;
    std::list<voxel::BoxKey> m_order;  ///< boxes in memory, least recently used last
    std::unordered_set<voxel::BoxKey, voxel::BoxKeyHash> m_loaded_once;
    BlockStats m_stats;
    std::size_t m_unseen_bytes = 0;
};

}  // namespace terravox::blocks
