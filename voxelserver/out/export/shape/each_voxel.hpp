#pragma once

#include <bit>

#include "common/voxel/box.hpp"

namespace terravox::exports {

/// Visits everything solid of one cell, as each_voxel() does of a box.
/// @param x, y, z its lowest corner
/// @param edge of its children: 16, 4 or 1 voxels
template <class Seen, class Hidden>
void each_voxel_of(const voxel::Box& box, const voxel::TreeCell& cell, int x, int y, int z,
                   int edge, const Seen& seen, const Hidden& hidden) {
    for (std::uint64_t left = cell.mask; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        const int cx = x + (bit & 3) * edge;
        const int cy = y + (bit >> 4) * edge;
        const int cz = z + (bit >> 2 & 3) * edge;
        if ((cell.detail >> bit & 1) == 0)
            hidden(cx, cy, cz, edge);
        else if (edge == 1)
            seen(cx, cy, cz, box.attrs()[cell.index_of(bit)]);
        else
            each_voxel_of(box, box.cells()[cell.index_of(bit)], cx, cy, cz, edge / 4, seen, hidden);
    }
}

/// Visits everything solid of a box, in an order that depends only on the box; local coordinates.
/// @param seen   called as (x, y, z, const VoxelAttr&) for each voxel that can be seen
/// @param hidden called as (x, y, z, edge) for each cube of edge 16, 4 or 1 that is solid and
/// hidden throughout: plain rock
template <class Seen, class Hidden>
void each_voxel(const voxel::Box& box, const Seen& seen, const Hidden& hidden) {
    for (int storey = 0; storey < voxel::Box::kRootCount; ++storey)
        each_voxel_of(box, box.cells()[static_cast<std::size_t>(storey)], 0, storey * 64, 0, 16,
                      seen, hidden);
}

}  // namespace terravox::exports
