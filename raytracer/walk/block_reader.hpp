#pragma once

#include <vector>

#include "raytracer/world/block_manager.hpp"

namespace terravox {

/// One thread's view of the block manager at one level: remembers the boxes met last, so that a walk takes no lock.
/// It may keep boxes that the manager has evicted: up to 512, or 32 when the manager's limit is small. Not thread-safe.
class BlockReader {
public:
    BlockReader(BlockManager& blocks, int level)
        : m_blocks(blocks), m_level(level), m_side_bits(blocks.limit_bytes() < kSmallLimit_bytes ? 2 : 4), m_slots(std::size_t{2} << (2 * m_side_bits)) {}

    /// @param bx, by, bz box coordinates of this level
    [[nodiscard]] const BlockRef& get(std::int32_t bx, std::int32_t by, std::int32_t bz) {
        // Neighbours get slots of their own: a ray that goes to and fro between boxes must not fetch them again and again.
        const std::int32_t side = (1 << m_side_bits) - 1;
        Slot& slot = m_slots[static_cast<std::size_t>((bx & side) | (bz & side) << m_side_bits | (by & 1) << (2 * m_side_bits))];
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
    static constexpr std::size_t kSmallLimit_bytes = std::size_t{512} << 20;
    struct Slot {
        std::int32_t bx = 0, by = 0, bz = 0;
        bool used = false;
        BlockRef ref;
    };
    BlockManager& m_blocks;
    int m_level;
    int m_side_bits;
    std::vector<Slot> m_slots;
};

}  // namespace terravox
