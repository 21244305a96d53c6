#pragma once

#include <cstdint>
#include <filesystem>

#include "voxelserver/data/lidar/las_file.hpp"

namespace terravox::laz {

struct Indexed {
    std::filesystem::path path;
    std::uint64_t bytes = 0;
    std::uint64_t cells = 0;
    std::uint64_t intervals = 0;
};

/// Writes the .lax file next to a point cloud: a quadtree whose cells hold intervals of points. The
/// file appears atomically, after it has been read back. Memory is bounded for any order of the
/// points: intervals of a cell are merged when there are too many. Ref: Isenburg, "LASindex -
/// simple spatial indexing of LiDAR data", European LiDAR Mapping Forum 2012.
/// @throws Error for a damaged file, one without points, one with a COPC hierarchy (its own index),
/// or a result that cannot be written
[[nodiscard]] Indexed write_lax(const std::filesystem::path& cloud);

}  // namespace terravox::laz
