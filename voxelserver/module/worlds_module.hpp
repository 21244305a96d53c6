#pragma once

#include <cstdint>

#include "voxelserver/voxelize/world/lidar_world.hpp"
#include "voxelserver/worlds/open/open_served_world.hpp"

namespace terravox::module {

// What terravox-worlds.so offers: two functions, under the names below. Worlds belong to the
// caller. Exceptions come through as they are: program and module are built together, by one
// compiler.
// Both throw Error when the module is of another version than the caller, kVersion.

/// open_lidar_world(), after the limit of GDAL's cache was set.
/// @param image_bytes geo::limit_gdal_cache() @throws what open_lidar_world throws
using OpenLidarWorld = voxelize::LidarWorld*(const char* version,
                                             const voxelize::LidarWorldOptions& options,
                                             util::StageTimes& times, std::int64_t image_bytes);
inline constexpr const char* kOpenLidarWorld = "terravox_open_lidar_world";

/// worlds::open_served_world(), after the same. @throws what it throws
using OpenServedWorld = worlds::ServedWorld*(const char* version,
                                             const worlds::ServeRequest& request,
                                             util::StageTimes& times, const std::stop_token& stop,
                                             std::int64_t image_bytes);
inline constexpr const char* kOpenServedWorld = "terravox_open_served_world";

}  // namespace terravox::module
