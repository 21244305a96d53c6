#pragma once

#include "voxelserver/data/lidar/las_file.hpp"

namespace terravox::lidar {

/// Checks the raw bytes of a LAS or LAZ file before they are passed to LASzip, which trusts counts
/// and offsets. Fills all members of LasInfo except the CRS.
/// @throws Error naming the file and the invalid value
[[nodiscard]] LasInfo check_las_header(const std::filesystem::path& path);

}  // namespace terravox::lidar
