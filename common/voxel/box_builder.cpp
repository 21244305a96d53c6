#include "common/voxel/box_builder.hpp"

#include <algorithm>

namespace terravox::voxel {

static_assert(kBoxSizeX == 64 && kBoxSizeZ == 64 && kBoxSizeY == 256);

namespace {

constexpr std::uint64_t kAll = ~std::uint64_t{0};

using Words = std::array<std::uint64_t, 16>;

// Transposes each of the four adjacent 16 x 16 bit squares in 16 words: bit 16 l + r of word c goes
// to bit 16 l + c of word r. Ref: Warren, "Hacker's Delight", section 7-3 (swap halves, then
// quarters, and so on).
void transpose_squares(Words& words) noexcept {
    std::uint64_t low_halves = 0x00FF00FF00FF00FFULL;
    for (unsigned half = 8; half != 0; half >>= 1, low_halves ^= low_halves << half)
        for (unsigned i = 0; i < 16; i = (i + half + 1) & ~half) {
            const std::uint64_t differing = (words[i] >> half ^ words[i + half]) & low_halves;
            words[i] ^= differing << half;
            words[i + half] ^= differing;
        }
}

// After the transposition: the four layers of 16 bits of brick `part`, lowest first.
std::uint64_t make_brick(const Words& layers, unsigned part) noexcept {
    const unsigned first = (part & 3) * 4;
    const unsigned lane = (part >> 2) * 16;
    std::uint64_t brick = 0;
    for (unsigned y = 0; y < 4; ++y)
        brick |= (layers[first + y] >> lane & 0xFFFF) << (16 * y);
    return brick;
}

}  // namespace

void ColumnBits::fill(int y0, int y1) noexcept {
    if (y0 >= y1)
        return;
    m_below = m_below || (y0 <= -1 && y1 > -1);
    m_above = m_above || (y0 <= kBoxSizeY && y1 > kBoxSizeY);
    y0 = std::max(y0, 0);
    y1 = std::min(y1, kBoxSizeY);
    if (y0 >= y1)
        return;
    const int first = y0 >> 6;
    const int last = (y1 - 1) >> 6;
    const std::uint64_t from_y0 = kAll << (y0 & 63);
    const std::uint64_t up_to_y1 = kAll >> (63 - ((y1 - 1) & 63));
    for (int i = first; i <= last; ++i)
        m_words[static_cast<std::size_t>(i)] |=
            (i == first ? from_y0 : kAll) & (i == last ? up_to_y1 : kAll);
}

bool ColumnBits::at(int y) const noexcept {
    if (y < 0)
        return m_below;
    if (y >= kBoxSizeY)
        return m_above;
    return (m_words[static_cast<std::size_t>(y >> 6)] >> (y & 63) & 1) != 0;
}

// The bricks of 64 layers, which correspond to one word of each column and one root of the tree.
// Stack bx + 16 bz holds the 16 bricks above each other on 4 x 4 columns; those not in `used` are
// air and uninitialised.
struct BoxBuilder::Storey {
    static constexpr unsigned kStacks = 16;
    struct Brick {
        std::uint64_t mask;
        std::uint64_t detail;
    };
    struct Stack {
        Brick bricks[16];
    };
    std::array<std::uint16_t, kStacks> used{};  ///< word bz, bit bx
    std::unique_ptr<Stack[]> stacks = std::make_unique_for_overwrite<Stack[]>(kStacks * kStacks);

    [[nodiscard]] const Brick* find(unsigned bx, unsigned by, unsigned bz) const noexcept {
        return (used[bz] >> bx & 1) != 0 ? &stacks[bz * kStacks + bx].bricks[by] : nullptr;
    }
    [[nodiscard]] TreeCell middle_at(unsigned bx, unsigned by, unsigned bz) const noexcept;
};

// The cell of 4 x 4 x 4 bricks from (bx, by, bz) on; `first` is left unset.
TreeCell BoxBuilder::Storey::middle_at(unsigned bx, unsigned by, unsigned bz) const noexcept {
    TreeCell middle;
    for (unsigned column = 0; column < 16; ++column) {
        const Brick* brick = find(bx + (column & 3), by, bz + (column >> 2));
        if (brick == nullptr)
            continue;
        for (unsigned y = 0; y < 4; ++y, ++brick) {
            const std::uint64_t bit = std::uint64_t{1} << (column + 16 * y);
            if (brick->mask != 0)
                middle.mask |= bit;
            if (brick->mask != 0 && (brick->mask != kAll || brick->detail != 0))
                middle.detail |= bit;
        }
    }
    return middle;
}

std::uint64_t BoxBuilder::detail_word(int x, int z, int word, std::uint64_t solid) const noexcept {
    const Column* here = &m_columns[index(x, z)];
    const std::uint64_t hidden = here->opaque.word(word) & here->opaque.word_from_above(word) &
                                 here->opaque.word_from_below(word) & here[-1].opaque.word(word) &
                                 here[1].opaque.word(word) & here[-kSide].opaque.word(word) &
                                 here[kSide].opaque.word(word);
    return solid & ~hidden;
}

// Turns columns of bits into bricks: four bits of a column are the column's share of a brick.
void BoxBuilder::sort_into_bricks(int word, Storey& storey) const noexcept {
    for (unsigned stack = 0; stack < 256; ++stack) {
        Words solid;
        Words detail;
        std::uint64_t any = 0;
        std::uint64_t all = kAll;
        std::uint64_t seen = 0;
        const int x0 = static_cast<int>(stack % 16) * 4;
        const int z0 = static_cast<int>(stack / 16) * 4;
        for (unsigned c = 0; c < 16; ++c) {
            const int x = x0 + static_cast<int>(c & 3);
            const int z = z0 + static_cast<int>(c >> 2);
            const Column& column = m_columns[index(x, z)];
            solid[c] = column.opaque.word(word) | column.clear.word(word);
            detail[c] = solid[c] == 0 ? 0 : detail_word(x, z, word, solid[c]);
            any |= solid[c];
            all &= solid[c];
            seen |= detail[c];
        }
        auto& used = storey.used[stack / 16];
        used = static_cast<std::uint16_t>(used & ~(1u << stack % 16));
        if (any == 0)
            continue;
        used = static_cast<std::uint16_t>(used | 1u << stack % 16);
        if (all != kAll)
            transpose_squares(solid);  // all ones and all zeros are their own transposition
        if (seen != 0)
            transpose_squares(detail);
        for (unsigned part = 0; part < 16; ++part)
            storey.stacks[stack].bricks[part] = {make_brick(solid, part), make_brick(detail, part)};
    }
}

BoxBuilder::Tree BoxBuilder::make_tree() const {
    Storey storey;
    std::array<TreeCell, Box::kRootCount> roots;
    std::vector<TreeCell> middles;
    std::vector<TreeCell> bricks;
    Tree tree;
    for (int root = 0; root < Box::kRootCount; ++root) {
        TreeCell& top = roots[static_cast<std::size_t>(root)];
        top.first = static_cast<std::uint32_t>(Box::kRootCount + middles.size());
        if (root * 64 >= m_end_y)
            continue;
        sort_into_bricks(root, storey);
        for (unsigned bit = 0; bit < 64; ++bit) {
            const unsigned bx0 = (bit & 3) * 4;
            const unsigned bz0 = (bit >> 2 & 3) * 4;
            const unsigned by0 = (bit >> 4) * 4;
            TreeCell middle = storey.middle_at(bx0, by0, bz0);
            if (middle.mask == 0)
                continue;
            top.mask |= std::uint64_t{1} << bit;
            if (middle.mask == kAll && middle.detail == 0)
                continue;
            top.detail |= std::uint64_t{1} << bit;
            middle.first = static_cast<std::uint32_t>(bricks.size());
            middles.push_back(middle);
            for (std::uint64_t left = middle.detail; left != 0; left &= left - 1) {
                const auto b = static_cast<unsigned>(std::countr_zero(left));
                const unsigned bx = bx0 + (b & 3);
                const unsigned by = by0 + (b >> 4);
                const unsigned bz = bz0 + (b >> 2 & 3);
                const auto* brick = storey.find(bx, by, bz);
                bricks.push_back(
                    {brick->mask, brick->detail, static_cast<std::uint32_t>(tree.attr_count), 0});
                tree.attr_count += static_cast<std::size_t>(std::popcount(brick->detail));
                const auto byte = [](unsigned v) { return static_cast<std::uint8_t>(v); };
                tree.corners.push_back(
                    {byte(bx * 4), byte(static_cast<unsigned>(root) * 64 + by * 4), byte(bz * 4)});
            }
        }
    }
    if (std::none_of(roots.begin(), roots.end(),
                     [](const TreeCell& root) { return root.mask != 0; }))
        return tree;
    tree.first_brick = roots.size() + middles.size();
    for (TreeCell& middle : middles)
        middle.first += static_cast<std::uint32_t>(tree.first_brick);
    tree.cells.reserve(tree.first_brick + bricks.size());
    tree.cells.assign(roots.begin(), roots.end());
    tree.cells.insert(tree.cells.end(), middles.begin(), middles.end());
    tree.cells.insert(tree.cells.end(), bricks.begin(), bricks.end());
    return tree;
}

}  // namespace terravox::voxel
