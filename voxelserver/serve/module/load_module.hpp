#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "voxelserver/make/voxelize/world/lidar_world.hpp"
#include "voxelserver/make/worlds/open/open_served_world.hpp"

namespace terravox::module {

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
