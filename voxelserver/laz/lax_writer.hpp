#pragma once

#include <cstdint>
#include <filesystem>

#include "voxelserver/lidar/las_file.hpp"

namespace terravox::laz {

struct Indexed {
    std::filesystem::path path;
    std::uint64_t bytes = 0, cells = 0, intervals = 0;
};

/// Writes the .lax file beside a point cloud: a quadtree whose cells hold intervals of points. The
/// file appears whole or not at all and has been read back. Memory is bounded whatever the order of
/// the points: intervals of a cell grow together when there are too many. Ref: Isenburg, "LASindex
/// - simple spatial indexing of LiDAR data", European LiDAR Mapping Forum 2012.
/// @throws Error for a damaged file, one without points, one with a COPC hierarchy (its own index),
/// or a result that cannot be written
[[nodiscard]] Indexed write_lax(const std::filesystem::path& cloud);

}  // namespace terravox::laz
