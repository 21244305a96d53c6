#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "common/voxel/box.hpp"
#include "voxelserver/data/imagery/raster.hpp"
#include "voxelserver/make/worlds/heightmap/height_grid.hpp"

namespace terravox::heightmap {

/// The columns of one stack of boxes: one past the highest voxel, with a margin of one, and the
/// looks of the stack's own columns.
class HeightmapColumns {
public:
    static constexpr std::int32_t kNothing = std::numeric_limits<std::int32_t>::min();
    static constexpr int kSide = voxel::kBoxSizeX + 2;

    /// @param heights of 66 x 66 columns
    /// @param colours of the inner 64 x 64, or empty
    HeightmapColumns(int level, const ColumnHeights& heights, const imagery::Raster& colours);

    /// One past the highest voxel of a column, in voxels of the level; kNothing: the column is air.
    /// @param x, z in [-1, 65)
    [[nodiscard]] std::int32_t top(int x, int z) const noexcept {
        return m_tops[static_cast<std::size_t>((z + 1) * kSide + x + 1)];
    }
    /// Top of the highest column; kNothing: all are air.
    [[nodiscard]] std::int32_t highest() const noexcept { return m_highest; }
    /// Top of the lowest column that has ground.
    [[nodiscard]] std::int32_t lowest() const noexcept { return m_lowest; }
    /// The voxel `depth` voxels under the highest one of a column; x, z in [0, 64).
    [[nodiscard]] voxel::VoxelAttr attr(int x, int z, std::int32_t depth) const noexcept;
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        return sizeof(*this) + m_tops.capacity() * 4 +
               m_appearances.capacity() * sizeof(voxel::VoxelAttr);
    }

private:
    [[nodiscard]] static voxel::VoxelAttr appearance(double slope, const imagery::Raster& colours,
                                                     std::size_t at) noexcept;
    std::vector<std::int32_t> m_tops;
    std::vector<voxel::VoxelAttr> m_appearances;
    std::int32_t m_highest = kNothing;
    std::int32_t m_lowest = std::numeric_limits<std::int32_t>::max();
};

}  // namespace terravox::heightmap
