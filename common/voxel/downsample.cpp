#include "common/voxel/box_builder.hpp"

#include <algorithm>
#include <vector>

#include "common/voxel/coarse_rule.hpp"

namespace terravox::voxel {
namespace {

constexpr std::uint64_t kAll = ~std::uint64_t{0};
constexpr TreeCell kAir{0, 0, 0, 0};
constexpr TreeCell kHidden{kAll, 0, 0, 0};

// A cell of a fine box. Air and hidden rock are represented as cells too, so that the steps below
// need not distinguish them; these have no box.
struct Node {
    const TreeCell* cell = &kAir;
    const Box* box = nullptr;
    [[nodiscard]] Node child(int bit) const noexcept {
        if ((cell->mask >> bit & 1) == 0)
            return {};
        if ((cell->detail >> bit & 1) == 0)
            return {&kHidden, nullptr};
        return {&box->cells()[cell->compute_index(bit)], box};
    }
    /// For bricks. Empty for air and hidden rock.
    [[nodiscard]] std::span<const VoxelAttr> attrs() const noexcept {
        return box == nullptr
                   ? std::span<const VoxelAttr>{}
                   : box->attrs().subspan(cell->first,
                                          static_cast<std::size_t>(std::popcount(cell->detail)));
    }
};
/// The 2 x 2 x 2 cells that one coarse cell covers; index = dx + 2 dz + 4 dy.
using Eight = std::array<Node, 8>;

// Maps child `bit` of a coarse cell to its octant: it covers eight children, from `corner` on, of
// one of the eight fine cells.
struct Place {
    std::size_t octant;
    int corner;
};
constexpr Place find_place(int bit) noexcept {
    const int x = bit & 3;
    const int z = bit >> 2 & 3;
    const int y = bit >> 4;
    return {static_cast<std::size_t>(x >> 1 | (z >> 1) << 1 | (y >> 1) << 2),
            child_bit(2 * (x & 1), 2 * (y & 1), 2 * (z & 1))};
}

class CoarseTree {
public:
    CoarseTree(int level, const std::array<std::shared_ptr<const Box>, 8>& boxes) : m_level(level) {
        for (int root = 0; root < Box::kRootCount; ++root)
            m_roots[static_cast<std::size_t>(root)] = make_root(fine_roots(boxes, root));
    }

    [[nodiscard]] std::shared_ptr<const Box> box(const BoxKey& key) {
        if (std::all_of(m_roots.begin(), m_roots.end(),
                        [](const TreeCell& root) { return root.mask == 0; }))
            return nullptr;
        const auto middle_base = static_cast<std::uint32_t>(m_roots.size());
        const auto brick_base = static_cast<std::uint32_t>(m_roots.size() + m_middles.size());
        for (TreeCell& cell : m_roots)
            cell.first += middle_base;
        for (TreeCell& cell : m_middles)
            cell.first += brick_base;
        std::vector<TreeCell> cells(m_roots.begin(), m_roots.end());
        cells.reserve(brick_base + m_bricks.size());
        cells.insert(cells.end(), m_middles.begin(), m_middles.end());
        cells.insert(cells.end(), m_bricks.begin(), m_bricks.end());
        return Box::from_arrays(key, cells, m_attrs);
    }

private:
    static Eight fine_roots(const std::array<std::shared_ptr<const Box>, 8>& boxes, int root) {
        Eight eight;
        for (int i = 0; i < 8; ++i) {
            const int fine = 2 * root + (i >> 2);
            const Box* box =
                boxes[static_cast<std::size_t>((i & 3) | (fine / Box::kRootCount) << 2)].get();
            if (box != nullptr)
                eight[static_cast<std::size_t>(i)] = {
                    &box->cells()[static_cast<std::size_t>(fine % Box::kRootCount)], box};
        }
        return eight;
    }

    // Calls visit(bit, eight fine cells) for each child of a coarse cell that needs work; air and
    // hidden rock are decided by their masks. `visit` returns the mask and detail of the child; a
    // child that is full and has no detail becomes hidden.
    template <class Visit>
    static void for_children(const Eight& parents, TreeCell& cell, const Visit& visit) {
        for (int bit = 0; bit < 64; ++bit) {
            const auto [octant, corner] = find_place(bit);
            const Node& parent = parents[octant];
            const std::uint64_t covered = kEightChildren << corner;
            const std::uint64_t flag = std::uint64_t{1} << bit;
            if ((parent.cell->mask & covered) == 0)
                continue;
            if ((parent.cell->mask & covered) == covered && (parent.cell->detail & covered) == 0) {
                cell.mask |= flag;
                continue;
            }
            Eight eight;
            for (int i = 0; i < 8; ++i)
                eight[static_cast<std::size_t>(i)] =
                    parent.child(corner + child_bit(i & 1, i >> 2, i >> 1 & 1));
            const auto [mask, detail] = visit(eight);
            if (mask != 0)
                cell.mask |= flag;
            if (mask != 0 && (mask != kAll || detail != 0))
                cell.detail |= flag;
        }
    }
    struct Masks {
        std::uint64_t mask;
        std::uint64_t detail;
    };

    TreeCell make_root(const Eight& roots) {
        TreeCell root{0, 0, static_cast<std::uint32_t>(m_middles.size()), 0};
        for_children(roots, root, [&](const Eight& middles) { return add_middle(middles); });
        return root;
    }

    Masks add_middle(const Eight& middles) {
        TreeCell middle{0, 0, static_cast<std::uint32_t>(m_bricks.size()), 0};
        for_children(middles, middle, [&](const Eight& bricks) { return add_brick(bricks); });
        if (middle.mask != 0 && (middle.mask != kAll || middle.detail != 0))
            m_middles.push_back(middle);
        return {middle.mask, middle.detail};
    }

    Masks add_brick(const Eight& bricks) {
        TreeCell brick{0, 0, static_cast<std::uint32_t>(m_attrs.size()), 0};
        std::array<CoarseVoxels, 8> octants;
        for (int i = 0; i < 8; ++i) {
            const Node& fine = bricks[static_cast<std::size_t>(i)];
            CoarseVoxels& coarse = octants[static_cast<std::size_t>(i)];
            if (fine.cell->mask == 0)
                continue;
            if (fine.box == nullptr)
                coarse.solid = kCorners;
            else
                coarse = coarse_voxels(*fine.cell, fine.attrs(), m_level);
            const int shift = child_bit(2 * (i & 1), 2 * (i >> 2), 2 * (i >> 1 & 1));
            brick.mask |= gather_corners(coarse.solid) << shift;
            brick.detail |= gather_corners(coarse.seen) << shift;
        }
        for (std::uint64_t left = brick.detail; left != 0; left &= left - 1) {
            const auto [octant, corner] = find_place(std::countr_zero(left));
            const Node& fine = bricks[octant];
            m_attrs.push_back(coarse_attr(*fine.cell, fine.attrs(), octants[octant], corner));
        }
        if (brick.mask != 0 && (brick.mask != kAll || brick.detail != 0))
            m_bricks.push_back(brick);
        return {brick.mask, brick.detail};
    }

    int m_level;
    std::array<TreeCell, Box::kRootCount> m_roots;
    std::vector<TreeCell> m_middles;
    std::vector<TreeCell> m_bricks;
    std::vector<VoxelAttr> m_attrs;
};

}  // namespace

std::shared_ptr<const Box> downsample(const BoxKey& key,
                                      const std::array<std::shared_ptr<const Box>, 8>& children) {
    return CoarseTree(key.level, children).box(key);
}

}  // namespace terravox::voxel
