#pragma once

#include <algorithm>
#include <vector>

#include "raytracer/core/blocks/block_manager.hpp"

namespace terravox::walk {

/// One thread's view of the block manager: it caches and pins the boxes met last, so that a walk
/// takes no lock. Not thread-safe.
class BlockReader {
public:
    /// @param budget_bytes of boxes that it may pin, including held ones; only the last few may
    /// exceed it
    explicit BlockReader(blocks::BlockManager& blocks,
                         std::size_t budget_bytes = std::size_t{64} << 20)
        : m_blocks(blocks),
          m_budget_bytes(std::min(budget_bytes, blocks.limit_bytes() / 16)),
          m_slots(kSlots) {}

    /// @return nullptr when the box is not in memory. The pointer is valid until the next call or,
    /// while the reader is holding, until release().
    [[nodiscard]] const blocks::Block* get(const voxel::BoxKey& key) {
        // Neighbours get slots of their own: rays that go to and fro between boxes must not fetch
        // them again and again. 32 boxes of level 0 are 2048 voxels wide.
        const auto slot_index = static_cast<std::size_t>(
            (key.bx & 31) | (key.bz & 31) << 5 | (key.by & 1) << 10 | (key.level & 1) << 11);
        Slot& slot = m_slots[slot_index];
        if (slot.block && slot.key == key)
            return slot.block.get();
        return fetch(slot, key);
    }
    /// From now on, blocks that get() has returned stay valid, until release().
    void hold() noexcept { m_holding = true; }
    /// Whether holding keeps so many bytes that release() should be called.
    [[nodiscard]] bool holds_much() const noexcept {
        return m_held_bytes > 0 && m_bytes + m_held_bytes > m_budget_bytes;
    }
    void release() noexcept {
        m_held.clear();
        m_held_bytes = 0;
        m_holding = false;
    }
    [[nodiscard]] blocks::BlockManager& blocks() noexcept { return m_blocks; }

private:
    static constexpr std::size_t kSlots = 4096;
    struct Slot {
        voxel::BoxKey key;
        blocks::BlockPin block;
    };
    void drop(Slot& slot) {
        if (!slot.block)
            return;
        m_bytes -= slot.block->memory_bytes();
        if (m_holding) {
            m_held_bytes += slot.block->memory_bytes();
            m_held.push_back(std::move(slot.block));
        }
        slot.block = nullptr;
    }
    const blocks::Block* fetch(Slot& slot, const voxel::BoxKey& key) {
        blocks::BlockPin block = m_blocks.find(key);
        if (!block)
            return nullptr;
        drop(slot);
        if (m_bytes + block->memory_bytes() > m_budget_bytes)
            std::for_each(m_slots.begin(), m_slots.end(), [this](Slot& other) { drop(other); });
        m_bytes += block->memory_bytes();
        slot.key = key;
        slot.block = std::move(block);
        return slot.block.get();
    }
    blocks::BlockManager& m_blocks;
    std::size_t m_budget_bytes;
    std::size_t m_bytes = 0;
    std::vector<Slot> m_slots;
    bool m_holding = false;
    std::vector<blocks::BlockPin> m_held;
    std::size_t m_held_bytes = 0;
};

}  // namespace terravox::walk
