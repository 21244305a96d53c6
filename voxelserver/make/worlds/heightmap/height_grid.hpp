#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "voxelserver/data/grid/frame.hpp"
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
    class Lease;
    struct Sum;
    void add_between(HeightFile& file, const HeightFile::Grid& grid, Sum& sum) const;
    void add_means(HeightFile& file, const HeightFile::Grid& grid, double side, Sum& sum) const;

    const std::vector<File> m_files;
    const grid::Frame m_frame;
    const std::size_t m_max_idle;
    std::mutex m_mutex;
    std::vector<Open> m_idle;  ///< sets of files that no thread reads now
};

}  // namespace terravox::heightmap
