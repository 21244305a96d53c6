#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "common/voxel/box.hpp"

namespace terravox::voxel {

/// One column of a box as bits, y in [0, 256), plus the voxels directly below (y = -1) and above (y
/// = 256).
class ColumnBits {
public:
    /// Sets [y0, y1), clipped to [-1, 257).
    void fill(int y0, int y1) noexcept;
    [[nodiscard]] bool at(int y) const noexcept;  ///< y in [-1, 257)
    [[nodiscard]] std::uint64_t word(int i) const noexcept {
        return m_words[static_cast<std::size_t>(i)];
    }
    /// The word shifted so that bit y = the voxel at y + 1.
    [[nodiscard]] std::uint64_t word_from_above(int i) const noexcept {
        return word(i) >> 1 | (i < 3 ? word(i + 1) : std::uint64_t{m_above}) << 63;
    }
    /// The word shifted so that bit y = the voxel at y - 1.
    [[nodiscard]] std::uint64_t word_from_below(int i) const noexcept {
        return word(i) << 1 | (i > 0 ? word(i - 1) >> 63 : std::uint64_t{m_below});
    }

private:
    std::array<std::uint64_t, 4> m_words{};
    bool m_below = false;
    bool m_above = false;
};

/// Builds a box from columns with a margin of one voxel on every side, so that hidden faces are
/// recognised across box borders.
///
/// Opaque voxels whose six neighbours are opaque become plain rock; the attributes of all others
/// are requested from `attr_at`. Not thread-safe.
class BoxBuilder {
public:
    BoxBuilder() : m_columns(kSide * kSide) {}

    /// Marks [y0, y1) (local y) of the column x, z in [-1, 65) as solid.
    /// @param opaque false for see_through() materials
    void add(int x, int z, int y0, int y1, bool opaque) noexcept {
        m_end_y = std::max(m_end_y, y1);
        Column& column = m_columns[index(x, z)];
        (opaque ? column.opaque : column.clear).fill(y0, y1);
    }

    using AttrAt = std::function<VoxelAttr(int x, int y, int z)>;
    /// @param attr_at any callable with the signature of AttrAt: called once for each visible voxel
    /// (local coordinates), brick by brick
    /// @return nullptr when the box contains nothing solid
    template <class Callable>
    [[nodiscard]] std::shared_ptr<const Box> build(const BoxKey& key,
                                                   const Callable& attr_at) const {
        const Tree tree = make_tree();
        if (tree.cells.empty())
            return nullptr;
        std::vector<VoxelAttr> attrs;
        attrs.reserve(tree.attr_count);
        for (std::size_t i = 0; i < tree.corners.size(); ++i) {
            const auto [x, y, z] = tree.corners[i];
            for (std::uint64_t left = tree.cells[tree.first_brick + i].detail; left != 0;
                 left &= left - 1) {
                const int bit = std::countr_zero(left);
                attrs.push_back(attr_at(x + (bit & 3), y + (bit >> 4), z + (bit >> 2 & 3)));
            }
        }
        return Box::from_arrays(key, tree.cells, attrs);
    }

private:
    static constexpr int kSide = kBoxSizeX + 2;
    /// The voxels added to one column; a voxel in both sets is opaque.
    struct Column {
        ColumnBits opaque;
        ColumnBits clear;
    };
    struct Corner {
        std::uint8_t x;
        std::uint8_t y;
        std::uint8_t z;
    };  ///< lowest corner voxel of a brick
    /// A complete box except for its attributes: cells[first_brick + i] lies at corners[i]. No
    /// cells: nothing is solid.
    struct Tree {
        std::vector<TreeCell> cells;
        std::vector<Corner> corners;
        std::size_t first_brick = 0;
        std::size_t attr_count = 0;
    };
    struct Storey;

    static std::size_t index(int x, int z) noexcept {
        return static_cast<std::size_t>((z + 1) * kSide + x + 1);
    }
    /// The voxels of column (x, z) that need attributes, as one word of 64 bits.
    [[nodiscard]] std::uint64_t detail_word(int x, int z, int word,
                                            std::uint64_t solid) const noexcept;
    void sort_into_bricks(int word, Storey& storey) const noexcept;
    [[nodiscard]] Tree make_tree() const;
    std::vector<Column> m_columns;
    int m_end_y = 0;  ///< exclusive upper bound of y of solid voxels
};

/// Boxes in levels: each covers eight of the next finer level, its children. Child i of a box lies
/// at (2 bx + dx, 2 by + dy, 2 bz + dz), i = dx + 2 dz + 4 dy.
struct Pyramid {
    template <class T>
    using Children = std::array<T, 8>;

    [[nodiscard]] static constexpr BoxKey child(const BoxKey& key, int i) noexcept {
        return {key.level - 1, 2 * key.bx + (i & 1), 2 * key.by + (i >> 2),
                2 * key.bz + (i >> 1 & 1)};
    }
    [[nodiscard]] static constexpr BoxKey parent(const BoxKey& key) noexcept {
        return {key.level + 1, key.bx >> 1, key.by >> 1, key.bz >> 1};
    }
    /// Which child of its parent a box is.
    [[nodiscard]] static constexpr std::size_t place(const BoxKey& key) noexcept {
        return static_cast<std::size_t>((key.bx & 1) + 2 * (key.bz & 1) + 4 * (key.by & 1));
    }
    /// @param make called with the key of each child, in order
    /// @return what it has made
    template <class Make>
    [[nodiscard]] static auto children(const BoxKey& key, const Make& make) {
        Children<decltype(make(key))> out;
        for (int i = 0; i < 8; ++i)
            out[static_cast<std::size_t>(i)] = make(child(key, i));
        return out;
    }
};

/// Makes the box of the next coarser level from its eight children, by the rule of coarse_voxels()
/// (coarse_rule.hpp): every coarse voxel depends only on its level and its own eight children, so
/// that boxes need no neighbours and no seams can arise.
///
/// A coarse voxel keeps attributes when one of the children that decided its material has some.
/// Where all eight are hidden, each neighbour touches four opaque voxels, and so becomes opaque or
/// shallow water: hidden voxels stay hidden, or become the rock under a bed. Cost: cells without
/// detail (air, rock) are skipped whole; the rest takes some 64-bit operations per brick and one
/// read of each stored attribute. Thread-safe.
/// @param children nullptr = air
/// @param key key of the result, level >= 1
/// @return nullptr when nothing is solid
[[nodiscard]] std::shared_ptr<const Box> downsample(
    const BoxKey& key, const Pyramid::Children<std::shared_ptr<const Box>>& children);

}  // namespace terravox::voxel
