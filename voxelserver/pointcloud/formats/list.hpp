#pragma once

#include <tuple>

#include "voxelserver/lidar/las_format.hpp"
#include "voxelserver/ply/ply_format.hpp"

namespace terravox::pointcloud {

/// All formats of points, a row each.
using Formats = std::tuple<lidar::LasFormat, ply::PlyFormat>;

}  // namespace terravox::pointcloud
