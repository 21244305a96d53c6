#pragma once

#include <filesystem>
#include <memory>

#include "voxelserver/data/pointcloud/point_source.hpp"

namespace terravox::pointcloud {

/// Opens a file of any format in the list (list.hpp).
/// @throws Error when it is missing, of no known format, or damaged
[[nodiscard]] std::unique_ptr<const PointSource> open_point_source(
    const std::filesystem::path& file);

}  // namespace terravox::pointcloud
