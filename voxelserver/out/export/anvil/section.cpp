#include "voxelserver/out/export/anvil/section.hpp"

#include <bit>

namespace terravox::exports::anvil {

using voxel::Material;
using voxel::TreeCell;

BlockId SectionReader::block_of(const voxel::VoxelAttr& attr) {
    if (!m_true || !attr.has_colour())
        return m_blocks.plain(attr.material);
    if (attr.material != m_last_material || attr.colour != m_last_colour) {
        m_last_material = attr.material;
        m_last_colour = attr.colour;
        m_last = m_blocks.painted(attr.material, attr.colour);
    }
    return m_last;
}

void SectionReader::read(const voxel::Box* box, int cx, int cy, int cz, Section& out) {
    out.fill(0);
    if (box == nullptr)
        return;
    // A cell of the second level of a box's trees is 16 voxels wide: a section.
    const TreeCell& root = box->cells()[static_cast<std::size_t>(cy >> 2)];
    const int place = voxel::child_bit(cx, cy, cz);
    if ((root.mask >> place & 1) == 0)
        return;
    const BlockId rock = m_blocks.plain(Material::kRock);
    if ((root.detail >> place & 1) == 0) {
        out.fill(rock);
        cut(box->key(), cx, cy, cz, out);
        return;
    }
    const TreeCell& cell = box->cells()[root.index_of(place)];
    out.uniform = false;
    out.blocks.fill(0);
    for (std::uint64_t bricks = cell.mask; bricks != 0; bricks &= bricks - 1) {
        const int bit = std::countr_zero(bricks);
        const int x = (bit & 3) * 4;
        const int z = (bit >> 2 & 3) * 4;
        const int y = (bit >> 4) * 4;
        const TreeCell* brick =
            (cell.detail >> bit & 1) != 0 ? &box->cells()[cell.index_of(bit)] : nullptr;
        for (std::uint64_t left = brick != nullptr ? brick->mask : ~std::uint64_t{0}; left != 0;
             left &= left - 1) {
            const int v = std::countr_zero(left);
            const bool seen = brick != nullptr && (brick->detail >> v & 1) != 0;
            out.blocks[Section::index(x + (v & 3), y + (v >> 4), z + (v >> 2 & 3))] =
                seen ? block_of(box->attrs()[brick->index_of(v)]) : rock;
        }
    }
    cut(box->key(), cx, cy, cz, out);
}

void SectionReader::cut(const voxel::BoxKey& key, int cx, int cy, int cz, Section& out) const {
    const std::int32_t x0 = key.bx * voxel::kBoxSizeX + cx * kSectionSize;
    const std::int32_t y0 = key.by * voxel::kBoxSizeY + cy * kSectionSize;
    const std::int32_t z0 = key.bz * voxel::kBoxSizeZ + cz * kSectionSize;
    constexpr int kLast = kSectionSize - 1;
    if (m_part.holds(x0, y0, z0) && m_part.holds(x0 + kLast, y0 + kLast, z0 + kLast))
        return;
    if (out.uniform) {
        out.blocks.fill(out.blocks[0]);
        out.uniform = false;
    }
    for (int y = 0; y < kSectionSize; ++y)
        for (int z = 0; z < kSectionSize; ++z)
            for (int x = 0; x < kSectionSize; ++x)
                if (!m_part.holds(x0 + x, y0 + y, z0 + z))
                    out.blocks[Section::index(x, y, z)] = 0;
}

}  // namespace terravox::exports::anvil
