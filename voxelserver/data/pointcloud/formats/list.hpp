#pragma once

#include <tuple>

#include "voxelserver/data/lidar/las_source.hpp"
#include "voxelserver/data/ply/ply_source.hpp"

namespace terravox::pointcloud {

/// The list of all point formats; add new ones here.
using Formats = std::tuple<lidar::LasFormat, ply::PlyFormat>;

}  // namespace terravox::pointcloud
