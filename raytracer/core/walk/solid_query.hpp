#pragma once

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

}  // namespace terravox::walk
