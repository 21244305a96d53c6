#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "raytracer/core/walk/block_reader.hpp"
#include "raytracer/core/walk/level_cut.hpp"

namespace terravox::walk {

/// A block of level-0 voxels; both ends are included.
struct VoxelRange {
    std::int32_t low[3], high[3];
};

/// Tests, with the masks of the 64-trees, whether a range may contain anything solid. Holes and
/// boxes that are not in memory count as solid. Use one object per thread.
class SolidQuery {
public:
    SolidQuery(BlockReader& reader, const LevelCut& cut) : m_reader(reader), m_cut(cut) {}

    /// @param grain_shift cells of 2^grain_shift level-0 voxels are fine enough for the answer,
    /// which may be true for a cell that holds something solid next to the range
    [[nodiscard]] bool any_solid(const VoxelRange& range, int grain_shift);
    /// Level of the cut at the last range; the steps of a march should not be finer.
    [[nodiscard]] int level() const noexcept { return m_level; }

private:
    [[nodiscard]] bool column(int level, std::int32_t bx, std::int32_t bz, const VoxelRange& range,
                              int grain_shift);
    [[nodiscard]] bool box(const voxel::Box& box, const VoxelRange& local, int grain_shift);
    BlockReader& m_reader;
    const LevelCut& m_cut;
    int m_level = 0;
};

/// Of slopes times distances, in double.
inline constexpr double kSlabRounding_voxel = 1e-3;

/// Moves a plane onwards while the slab in front of it is free, slab after slab, each aligned and
/// as thick as can be shown to be free.
/// @param plane in: where to begin; out: where it stopped, or `end` or slightly beyond it
/// @param towards 1 or -1
/// @param max_fine number of slabs of the finest thickness to try
/// @param free_between bool(near, far, shift): whether the slab between two planes, 2^shift thick,
/// is free
/// @return whether something stopped the plane before `end`
template <class FreeBetween>
bool march_slabs(std::int32_t& plane, std::int32_t end, int towards, const SolidQuery& query,
                 int max_fine, const FreeBetween& free_between) {
    constexpr int kMaxShift = 30;
    int shift = kMaxShift;
    int fine = 0;
    while (towards > 0 ? plane < end : plane > end) {
        const int aligned =
            plane == 0 ? kMaxShift : std::countr_zero(static_cast<std::uint32_t>(plane));
        shift = std::max(std::min({shift, query.level() + LevelCut::kSideBits, aligned}), 0);
        while (true) {
            // Slabs thinner than a voxel reveal nothing more, and many of the thinnest cost more
            // than tracing the rays.
            if (shift <= query.level() && fine++ >= max_fine)
                return true;
            const std::int32_t next = plane + towards * (std::int32_t{1} << shift);
            if (free_between(plane, next, shift)) {
                plane = next;
                shift += 2;
                break;
            }
            if (shift <= query.level())
                return true;
            shift = std::max(shift - 2, 0);
        }
    }
    return false;
}

/// log2 size of the cells whose masks decide over a slab of 2^shift voxels: a quarter of its
/// thickness.
[[nodiscard]] inline int grain_of_slab(int shift) noexcept {
    return std::max(shift - 2, 0);
}

}  // namespace terravox::walk
