#pragma once

#include <cstddef>
#include <cstdint>
#include <terravox/control.hpp>

#include "common/thread/parallel.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/apps/library/guarded.hpp"
#include "raytracer/apps/library/state.hpp"

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
            visit(m_box.cells()[cell.compute_index(bit)], x, y, z, side);
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

/// A column of boxes of a block.
struct BoxColumnAt {
    std::int32_t bx = 0;
    std::int32_t bz = 0;
    std::int32_t by_begin = 0;  ///< of the boxes of the block in it, half-open
    std::int32_t by_end = 0;
};

/// The boxes over a block, in numbers of boxes of its level.
[[nodiscard]] inline voxel::BoxRange find_boxes(const voxel::VoxelBounds& block,
                                                int level) noexcept {
    voxel::BoxRange out = voxel::boxes_over(block, 0);
    out.min.level = out.max.level = level;
    return out;
}

/// Calls work(column) for each column of boxes over a block, on several threads.
/// @param block in voxels of the level
/// @throws Stopped, and what work throws
template <class Work>
void each_box_column(const voxel::VoxelBounds& block, int level, int threads,
                     const Control& control, const Work& work) {
    const voxel::BoxRange range = find_boxes(block, level);
    const auto across = static_cast<std::size_t>(range.max.bx - range.min.bx);
    const auto count = across * static_cast<std::size_t>(range.max.bz - range.min.bz);
    Steps steps(control, count);
    thread::parallel_for(count, threads, [&](std::size_t i) {
        check_stop(control);
        work(BoxColumnAt{range.min.bx + static_cast<std::int32_t>(i % across),
                         range.min.bz + static_cast<std::int32_t>(i / across), range.min.by,
                         range.max.by});
        steps.add_one();
    });
}

}  // namespace terravox
