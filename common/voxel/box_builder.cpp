#include "common/voxel/box_builder.hpp"

#include <algorithm>

namespace terravox::voxel {

static_assert(kBoxSizeX == 64 && kBoxSizeZ == 64 && kBoxSizeY == 256);

void ColumnBits::fill(int y0, int y1) noexcept {
    if (y0 >= y1) return;
    m_below = m_below || (y0 <= -1 && y1 > -1);
    m_above = m_above || (y0 <= kBoxSizeY && y1 > kBoxSizeY);
    y0 = std::max(y0, 0), y1 = std::min(y1, kBoxSizeY);
    for (int i = y0 >> 6; i <= (y1 - 1) >> 6 && y0 < y1; ++i) {
        const int first = std::max(y0 - i * 64, 0), count = std::min(y1 - i * 64, 64) - first;
        const std::uint64_t run = count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
        m_words[static_cast<std::size_t>(i)] |= run << first;
    }
}

bool ColumnBits::at(int y) const noexcept {
    if (y < 0) return m_below;
    if (y >= kBoxSizeY) return m_above;
    return (m_words[static_cast<std::size_t>(y >> 6)] >> (y & 63) & 1) != 0;
}

std::uint64_t ColumnBits::word_from_above(int i) const noexcept {
    const std::uint64_t carried = i < 3 ? word(i + 1) << 63 : std::uint64_t{m_above} << 63;
    return word(i) >> 1 | carried;
}

std::uint64_t ColumnBits::word_from_below(int i) const noexcept {
    const std::uint64_t carried = i > 0 ? word(i - 1) >> 63 : std::uint64_t{m_below};
    return word(i) << 1 | carried;
}

void BoxBuilder::add(int x, int z, int y0, int y1, bool opaque) noexcept {
    m_solid[index(x, z)].fill(y0, y1);
    if (opaque) m_opaque[index(x, z)].fill(y0, y1);
}

std::uint64_t BoxBuilder::detail_word(int x, int z, int word) const noexcept {
    const ColumnBits& opaque = m_opaque[index(x, z)];
    const std::uint64_t hidden = opaque.word(word) & opaque.word_from_above(word) & opaque.word_from_below(word) &
                                 m_opaque[index(x - 1, z)].word(word) & m_opaque[index(x + 1, z)].word(word) &
                                 m_opaque[index(x, z - 1)].word(word) & m_opaque[index(x, z + 1)].word(word);
    return m_solid[index(x, z)].word(word) & ~hidden;
}

std::shared_ptr<const Box> BoxBuilder::build(const BoxKey& key, const AttrAt& attr_at) const {
    struct Brick { std::uint64_t mask = 0, detail = 0; };
    constexpr std::uint64_t kAll = ~std::uint64_t{0};
    constexpr int kBricks = 16, kBricksY = 64;
    std::vector<Brick> bricks(static_cast<std::size_t>(kBricks) * kBricks * kBricksY);
    const auto brick_index = [](int x, int y, int z) { return static_cast<std::size_t>((y * kBricks + z) * kBricks + x); };

    // Step 1: turn columns of bits into bricks: four bits of a column are the column's share of a brick.
    bool any = false;
    for (int z = 0; z < kBoxSizeZ; ++z)
        for (int x = 0; x < kBoxSizeX; ++x)
            for (int word = 0; word < 4; ++word) {
                const std::uint64_t solid = m_solid[index(x, z)].word(word);
                if (solid == 0) continue;
                any = true;
                const std::uint64_t detail = detail_word(x, z, word);
                const int base = child_bit(x, 0, z);
                for (int part = 0; part < 16; ++part) {
                    const std::uint64_t four = solid >> (part * 4) & 15, four_detail = detail >> (part * 4) & 15;
                    if (four == 0) continue;
                    Brick& brick = bricks[brick_index(x >> 2, word * 16 + part, z >> 2)];
                    // Bits y, y+1, y+2, y+3 go 16 apart.
                    const auto spread = [](std::uint64_t v) { return (v & 1) | (v & 2) << 15 | (v & 4) << 30 | (v & 8) << 45; };
                    brick.mask |= spread(four) << base;
                    brick.detail |= spread(four_detail) << base;
                }
            }
    if (!any) return nullptr;

    // Step 2: the two upper levels, and all cells in order: roots, 16^3 cells, bricks.
    std::vector<TreeCell> roots(Box::kRootCount), middles, leaves;
    std::vector<VoxelAttr> attrs;
    for (int root = 0; root < Box::kRootCount; ++root) {
        TreeCell& top = roots[static_cast<std::size_t>(root)];
        top.first = static_cast<std::uint32_t>(middles.size());
        for (int bit = 0; bit < 64; ++bit) {
            const int cx = (bit & 3) * 4, cz = (bit >> 2 & 3) * 4, cy = root * 16 + (bit >> 4) * 4;
            TreeCell middle;
            for (int b = 0; b < 64; ++b) {
                const Brick& brick = bricks[brick_index(cx + (b & 3), cy + (b >> 4), cz + (b >> 2 & 3))];
                if (brick.mask == 0) continue;
                middle.mask |= std::uint64_t{1} << b;
                if (brick.mask != kAll || brick.detail != 0) middle.detail |= std::uint64_t{1} << b;
            }
            if (middle.mask == 0) continue;
            top.mask |= std::uint64_t{1} << bit;
            if (middle.mask == kAll && middle.detail == 0) continue;
            top.detail |= std::uint64_t{1} << bit;
            middle.first = static_cast<std::uint32_t>(leaves.size());
            middles.push_back(middle);
            for (int b = 0; b < 64; ++b) {
                if ((middle.detail >> b & 1) == 0) continue;
                const int bx = cx + (b & 3), by = cy + (b >> 4), bz = cz + (b >> 2 & 3);
                const Brick& brick = bricks[brick_index(bx, by, bz)];
                leaves.push_back({brick.mask, brick.detail, static_cast<std::uint32_t>(attrs.size()), 0});
                for (std::uint64_t left = brick.detail; left != 0; left &= left - 1) {
                    const int v = std::countr_zero(left);
                    attrs.push_back(attr_at(bx * 4 + (v & 3), by * 4 + (v >> 4), bz * 4 + (v >> 2 & 3)));
                }
            }
        }
    }
    const auto middle_base = static_cast<std::uint32_t>(roots.size());
    const auto leaf_base = static_cast<std::uint32_t>(roots.size() + middles.size());
    for (TreeCell& cell : roots) cell.first += middle_base;
    for (TreeCell& cell : middles) cell.first += leaf_base;
    std::vector<TreeCell> cells = std::move(roots);
    cells.insert(cells.end(), middles.begin(), middles.end());
    cells.insert(cells.end(), leaves.begin(), leaves.end());
    return Box::from_arrays(key, cells, attrs);
}

}  // namespace terravox::voxel
