#pragma once

#include <tuple>

#include "voxelserver/lidar/las_format.hpp"
#include "voxelserver/ply/ply_format.hpp"

namespace terravox::pointcloud {

/// The list of all point formats; add new ones here.
using Formats = std::tuple<lidar::LasFormat, ply::PlyFormat>;

}  // namespace terravox::pointcloud
