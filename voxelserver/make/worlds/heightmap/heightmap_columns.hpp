#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "common/util/handle_pool.hpp"
#include "common/voxel/box.hpp"
#include "voxelserver/data/grid/frame.hpp"
#include "voxelserver/data/imagery/raster.hpp"
#include "voxelserver/make/worlds/heightmap/height_file.hpp"

namespace terravox::heightmap {

/// Heights of columns of voxels of a level, in voxels of that level from the height 0 up; NaN where
/// there is nothing. Row by row.
struct ColumnHeights {
    std::int32_t x = 0;
    std::int32_t z = 0;
    int width = 0;
    int height = 0;
    std::vector<double> voxels;
    [[nodiscard]] double at(std::int32_t column_x, std::int32_t column_z) const noexcept {
        return voxels[static_cast<std::size_t>(column_z - z) * static_cast<std::size_t>(width) +
                      static_cast<std::size_t>(column_x - x)];
    }
};

/// All rasters of a world, in layers: in each column, the first raster with heights there counts.
/// Thread-safe: every caller reads from its own open files, some of which stay open.
///
/// The height of a column depends on the column alone, not on the requested rectangle: at its
/// middle, it is bilinear between the middles of the cells; where cells are smaller than the voxel,
/// it is the mean of those inside. Where rasters adjoin, one adds the cells that another lacks.
class HeightGrid {
public:
    struct File {
        Reading reading;
        HeightFile::Outline outline;
    };
    /// @param files in the frame's CRS, north or south up; by precedence, the first one wins
    HeightGrid(std::vector<File> files, grid::Frame frame, int threads);

    /// @throws Error naming the damaged file
    [[nodiscard]] ColumnHeights read(int level, std::int32_t x, std::int32_t z, int width,
                                     int height);

private:
    /// Files that one caller has open, with their indices in m_files; the last used is last.
    using Open = std::vector<std::pair<std::size_t, std::unique_ptr<HeightFile>>>;
    struct Sum;
    HeightFile& open_file(Open& open, std::size_t i) const;
    void add_between(HeightFile& file, const HeightFile::Grid& grid, Sum& sum) const;
    void add_means(HeightFile& file, const HeightFile::Grid& grid, double side, Sum& sum) const;

    const std::vector<File> m_files;
    const grid::Frame m_frame;
    util::HandlePool<std::unique_ptr<Open>> m_idle;  ///< sets of files that no thread reads now
};

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
