#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "common/voxel/box.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::exports {

/// The voxel whose lowest north-western corner is the origin of a shape's file: the middle of the
/// part, at its bottom. Coordinates stay small there (32-bit floats), and the shape stands on the
/// ground grid of the program that opens it.
[[nodiscard]] std::array<std::int32_t, 3> make_origin(const Part& part) noexcept;

/// Metadata of the source world, in a fixed order, for formats that can store it; empty values are
/// left out.
/// @param axes describes the axes of the file
[[nodiscard]] std::vector<std::pair<std::string, std::string>> collect_facts(
    const Job& job, const std::string& axes);

/// Commits a file and its side-car FILE.georef.json, both or, on a full disk, neither, and reports
/// the file to the job. The side-car uses x east, y up, z south, as everywhere: of a file with z
/// up, x = X, y = Z, z = -Y.
/// @throws Error
void finish_file(Job& job, util::AtomicFile& file);

/// For a part without a single voxel to write.
/// @throws Error, always
[[noreturn]] void fail_for_nothing(const Job& job);

/// Visits everything solid of one cell, as each_voxel() does of a box.
/// @param x, y, z its lowest corner
/// @param edge of its children: 16, 4 or 1 voxels
template <class Seen, class Hidden>
void visit_each_voxel(const voxel::Box& box, const voxel::TreeCell& cell, int x, int y, int z,
                      int edge, const Seen& seen, const Hidden& hidden) {
    for (std::uint64_t left = cell.mask; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        const int cx = x + (bit & 3) * edge;
        const int cy = y + (bit >> 4) * edge;
        const int cz = z + (bit >> 2 & 3) * edge;
        if ((cell.detail >> bit & 1) == 0)
            hidden(cx, cy, cz, edge);
        else if (edge == 1)
            seen(cx, cy, cz, box.attrs()[cell.compute_index(bit)]);
        else
            visit_each_voxel(box, box.cells()[cell.compute_index(bit)], cx, cy, cz, edge / 4, seen,
                             hidden);
    }
}

/// Visits everything solid of a box, in an order that depends only on the box; local coordinates.
/// @param seen   called as (x, y, z, const VoxelAttr&) for each voxel that can be seen
/// @param hidden called as (x, y, z, edge) for each cube of edge 16, 4 or 1 that is solid and
/// hidden throughout: plain rock
template <class Seen, class Hidden>
void each_voxel(const voxel::Box& box, const Seen& seen, const Hidden& hidden) {
    for (int storey = 0; storey < voxel::Box::kRootCount; ++storey)
        visit_each_voxel(box, box.cells()[static_cast<std::size_t>(storey)], 0, storey * 64, 0, 16,
                         seen, hidden);
}

}  // namespace terravox::exports
