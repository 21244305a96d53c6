#include "raytracer/core/walk/surroundings.hpp"

#include <optional>
#include <span>

namespace terravox::walk {
namespace {

/// Which voxels of a box are solid, a brick of 4 x 4 x 4 at a time: neighbours mostly share one.
class BrickReader {
public:
    explicit BrickReader(const voxel::Box& box) : m_cells(box.cells()) {}

    /// Local coordinates, as those of Box::solid().
    [[nodiscard]] bool solid(std::int32_t x, std::int32_t y, std::int32_t z) noexcept {
        const std::int32_t brick = x >> 2 | z >> 2 << 4 | y >> 2 << 8;
        if (brick != m_brick) {
            m_brick = brick;
            m_mask = mask_at(x, y, z);
        }
        return (m_mask >> voxel::child_bit(x, y, z) & 1) != 0;
    }

private:
    [[nodiscard]] std::uint64_t mask_at(std::int32_t x, std::int32_t y,
                                        std::int32_t z) const noexcept {
        const voxel::TreeCell* cell = &m_cells[static_cast<std::size_t>(y >> 6)];
        for (int shift = 4; shift > 0; shift -= 2) {
            const int bit = voxel::child_bit(x >> shift, y >> shift, z >> shift);
            if ((cell->mask >> bit & 1) == 0)
                return 0;
            if ((cell->detail >> bit & 1) == 0)
                return ~std::uint64_t{0};
            cell = &m_cells[cell->compute_index(bit)];
        }
        return cell->mask;
    }
    std::span<const voxel::TreeCell> m_cells;
    std::int32_t m_brick = -1;
    std::uint64_t m_mask = 0;
};

}  // namespace

bool Surroundings::look(core::VoxelCoord v, int level, bool& solid) {
    const int own = m_cut.level_at(v.x << level, v.z << level, level);
    // Where the neighbour is coarser, what it is part of; where it is finer, its middle.
    const auto moved = [&](std::int32_t c) {
        return own >= level ? c >> (own - level) : (c << (level - own)) + (1 << (level - own - 1));
    };
    const std::int32_t x = moved(v.x);
    const std::int32_t y = moved(v.y);
    const std::int32_t z = moved(v.z);
    const voxel::BoxKey key{own, x >> 6, y >> 8, z >> 6};
    const blocks::Block* block = m_reader.get(key);
    if (block == nullptr) {
        m_missing = key;
        return false;
    }
    if (block->hole) {
        m_holes.insert(key);
        m_met_hole = true;
    }
    solid = block->hole || (block->box && block->box->solid(x & 63, y & 255, z & 63));
    return true;
}

Surroundings::Known& Surroundings::find_place(const Hit& hit) noexcept {
    const auto word = [](std::int32_t v) { return static_cast<std::uint32_t>(v); };
    // Neighbouring faces of each direction get places of their own.
    const std::uint32_t place = word(hit.voxel.x) + word(hit.voxel.z) * 67 +
                                word(hit.voxel.y) * 4441 +
                                static_cast<std::uint32_t>(hit.face) * 1361;
    return m_known[place % kKnown];
}

bool Surroundings::around(const Hit& hit, Seen& seen) {
    Known& known = find_place(hit);
    if (known.voxel == hit.voxel && known.level == hit.level && known.face == hit.face) {
        seen = {known.bits, 8};
        return true;
    }
    m_met_hole = false;
    const bool from_start = seen.looked == 0;
    if (!look_around(hit, seen))
        return false;
    // A hole has to be met again by each tile: it reports its own.
    if (from_start && !m_met_hole)
        known = {hit.voxel, hit.level, hit.face, seen.bits};
    return true;
}

bool Surroundings::look_around(const Hit& hit, Seen& seen) {
    const core::VoxelCoord front = neighbour(hit.voxel, hit.face);
    const int axis = core::to_axis(hit.face);
    const int a = (axis + 1) % 3;
    const int b = (axis + 2) % 3;
    // Usually all eight lie in the box that the ray has just been in.
    std::optional<BrickReader> whole;
    const std::int32_t x = front.x & 63;
    const std::int32_t y = front.y & 255;
    const std::int32_t z = front.z & 63;
    const bool amid = x > 0 && x < 63 && y > 0 && y < 255 && z > 0 && z < 63;
    if (amid && m_cut.level_at(front.x << hit.level, front.z << hit.level, hit.level) == hit.level)
        // For null, see look().
        if (const blocks::Block* block =
                m_reader.get({hit.level, front.x >> 6, front.y >> 8, front.z >> 6});
            block != nullptr && block->box)
            whole.emplace(*block->box);
    for (; seen.looked < 8; ++seen.looked) {
        // Of nine, without the middle.
        const int place = seen.looked < 4 ? seen.looked : seen.looked + 1;
        std::int32_t c[3] = {front.x, front.y, front.z};
        c[a] += place / 3 - 1;
        c[b] += place % 3 - 1;
        bool solid = false;
        if (whole)
            solid = whole->solid(c[0] & 63, c[1] & 255, c[2] & 63);
        else if (!look({c[0], c[1], c[2]}, hit.level, solid))
            return false;
        seen.bits = static_cast<std::uint8_t>(seen.bits | static_cast<int>(solid) << seen.looked);
    }
    return true;
}

}  // namespace terravox::walk
