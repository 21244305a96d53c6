#pragma once

#include "voxelserver/lidar/las_file.hpp"

namespace terravox::lidar {

/// Checks the raw bytes of a LAS or LAZ file before LASzip sees it, because LASzip trusts counts
/// and offsets. Fills everything of LasInfo but the CRS. @throws Error naming the file and the
/// value that cannot be
[[nodiscard]] LasInfo check_las_header(const std::filesystem::path& path);

}  // namespace terravox::lidar
