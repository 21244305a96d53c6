#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "voxelserver/make/voxelize/world/lidar_world.hpp"
#include "voxelserver/make/worlds/open/open_served_world.hpp"

namespace terravox::module {

// The interface of terravox-worlds.so: three functions, exported under the names below. The caller
// owns the returned worlds. Exceptions pass through unchanged: program and module are built
// together, by one compiler. All of them throw Error when the module's version differs from the
// caller's kVersion.

/// Calls open_lidar_world(), after setting the limit of GDAL's cache.
/// @param image_bytes argument of geo::limit_gdal_cache()
/// @throws what open_lidar_world throws
using OpenLidarWorld = voxelize::LidarWorld*(const char* version,
                                             const voxelize::LidarWorldOptions& options,
                                             util::StageTimes& times, std::int64_t image_bytes);
inline constexpr const char* kOpenLidarWorld = "terravox_open_lidar_world";

/// Calls worlds::open_served_world(), after setting the same limit.
/// @throws what it throws
using OpenServedWorld = worlds::ServedWorld*(const char* version,
                                             const worlds::ServeRequest& request,
                                             util::StageTimes& times, const std::stop_token& stop,
                                             std::int64_t image_bytes);
inline constexpr const char* kOpenServedWorld = "terravox_open_served_world";

/// Replaces extents (west, south, east, north) in one CRS by those around them in another; nullopt
/// for one that has no place there.
/// @throws Error for a CRS that is not understood
using PlaceExtents = void(const char* version, const std::string& from, const std::string& to_wkt,
                          std::span<std::optional<std::array<double, 4>>> extents);
inline constexpr const char* kPlaceExtents = "terravox_place_extents";

/// The path of terravox-worlds.so, next to the program.
[[nodiscard]] std::filesystem::path worlds_module();

// The functions below are in the module, which the first call loads (some 80 ms). Thread-safe. They
// throw Error when the module cannot be loaded.

/// Calls voxelize::open_lidar_world().
/// @param image_bytes memory limit for decoded images of all worlds together
/// @throws what open_lidar_world throws, with its type
[[nodiscard]] std::unique_ptr<voxelize::LidarWorld> open_lidar_world(
    const voxelize::LidarWorldOptions& options, util::StageTimes& times, std::size_t image_bytes);

/// Calls worlds::open_served_world().
/// @param image_bytes as above
/// @throws what open_served_world throws, with its type
[[nodiscard]] std::unique_ptr<worlds::ServedWorld> open_served_world(
    const worlds::ServeRequest& request, util::StageTimes& times, const std::stop_token& stop,
    std::size_t image_bytes);

/// Replaces extents (west, south, east, north) in one CRS by those around them in another; nullopt
/// for one that has no place there.
/// @throws Error for a CRS that is not understood
void place_extents(const std::string& from, const std::string& to_wkt,
                   std::span<std::optional<std::array<double, 4>>> extents);

}  // namespace terravox::module
