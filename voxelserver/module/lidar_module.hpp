#pragma once

#include <cstdint>

#include "voxelserver/voxelize/lidar_world.hpp"

namespace terravox::module {

/// What terravox-lidar.so offers, under the name terravox_open_lidar_world: open_lidar_world(),
/// after the limit of GDAL's cache was set. The world belongs to the caller. Exceptions come
/// through as they are: program and module are built together, by one compiler.
/// @param version kVersion of the caller  @param image_bytes geo::limit_gdal_cache()
/// @throws Error when the module is of another version; what open_lidar_world throws
using OpenLidarWorld = voxelize::LidarWorld*(const char* version,
                                             const voxelize::LidarWorldOptions& options,
                                             util::StageTimes& times, std::int64_t image_bytes);
inline constexpr const char* kOpenLidarWorld = "terravox_open_lidar_world";

}  // namespace terravox::module
