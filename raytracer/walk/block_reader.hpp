#pragma once

#include <array>

#include "raytracer/world/block_manager.hpp"

namespace terravox {

/// One thread's view of the block manager at one level: remembers the boxes met last, so that a walk takes no lock.
/// Holds at most kSlots boxes beyond the manager's limit. Not thread-safe.
class BlockReader {
public:
    BlockReader(BlockManager& blocks, int level) : m_blocks(blocks), m_level(level) {}

    /// @param bx, by, bz box coordinates of this level
    [[nodiscard]] const BlockRef& get(std::int32_t bx, std::int32_t by, std::int32_t bz) {
        Slot& slot = m_slots[static_cast<std::size_t>((bx & 3) | (bz & 3) << 2 | (by & 1) << 4)];
        if (slot.used && slot.bx == bx && slot.by == by && slot.bz == bz) return slot.ref;
        slot.ref = m_blocks.get({m_level, bx, by, bz});
        slot.bx = bx, slot.by = by, slot.bz = bz, slot.used = true;
        return slot.ref;
    }

    /// Voxel coordinates of this level. Holes count as solid.
    [[nodiscard]] bool solid(std::int32_t x, std::int32_t y, std::int32_t z) {
        const BlockRef& ref = get(x >> 6, y >> 8, z >> 6);
        return ref.hole || (ref.box && ref.box->solid(x & 63, y & 255, z & 63));
    }
    [[nodiscard]] int level() const noexcept { return m_level; }
    [[nodiscard]] BlockManager& blocks() noexcept { return m_blocks; }

private:
    static constexpr std::size_t kSlots = 32;
    struct Slot {
        std::int32_t bx = 0, by = 0, bz = 0;
        bool used = false;
        BlockRef ref;
    };
    BlockManager& m_blocks;
    int m_level;
    std::array<Slot, kSlots> m_slots;
};

}  // namespace terravox
