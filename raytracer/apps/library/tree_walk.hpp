#pragma once

#include <cstdint>

#include "common/voxel/box.hpp"

namespace terravox {

/// Visits what is solid in a box, from above: of two voxels of a column the upper one comes first.
/// `visitor.hidden(x, y, z, size)` is called for cubes of rock that has no attributes, with their
/// lowest corner; `visitor.brick(x, y, z, cell)` for cells of 4 x 4 x 4 voxels; and
/// `visitor.skips(x, z, size)` tells that nothing more is wanted of a square of columns.
template <class Visitor>
class TreeWalk {
public:
    TreeWalk(const voxel::Box& box, Visitor& visitor) : m_box(box), m_visitor(visitor) {}

    void run() {
        for (int root = voxel::Box::kRootCount - 1; root >= 0; --root)
            visit(m_box.cells()[static_cast<std::size_t>(root)], 0, root * kRootSide, 0, kRootSide);
    }

private:
    static constexpr int kRootSide = 64;
    static constexpr int kBrickSide = 4;

    void visit(const voxel::TreeCell& cell, int x0, int y0, int z0, int side) {
        if (cell.mask == 0 || m_visitor.skips(x0, z0, side))
            return;
        if (side == kBrickSide) {
            m_visitor.brick(x0, y0, z0, cell);
            return;
        }
        const int child = side / 4;
        for (int y = 3; y >= 0; --y)
            for (int bit = y * 16; bit < y * 16 + 16; ++bit)
                if ((cell.mask >> bit & 1) != 0)
                    visit_child(cell, bit, x0 + (bit & 3) * child, y0 + y * child,
                                z0 + (bit >> 2 & 3) * child, child);
    }

    void visit_child(const voxel::TreeCell& cell, int bit, int x, int y, int z, int side) {
        if ((cell.detail >> bit & 1) != 0)
            visit(m_box.cells()[cell.index_of(bit)], x, y, z, side);
        else if (!m_visitor.skips(x, z, side))
            m_visitor.hidden(x, y, z, side);
    }

    const voxel::Box& m_box;
    Visitor& m_visitor;
};

template <class Visitor>
void walk_tree(const voxel::Box& box, Visitor& visitor) {
    TreeWalk<Visitor>(box, visitor).run();
}

}  // namespace terravox
