#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>

#include "voxelserver/voxelize/lidar_world.hpp"

namespace terravox::module {

/// terravox-lidar.so, beside the program.
[[nodiscard]] std::filesystem::path lidar_module();

/// voxelize::open_lidar_world(), which is in the module: loads it with the first call (some 80 ms).
/// Thread-safe.
/// @param image_bytes what may be kept of decoded images, all worlds together
/// @throws Error when the module cannot be loaded; what open_lidar_world throws, with its type
[[nodiscard]] std::unique_ptr<voxelize::LidarWorld> open_lidar_world(
    const voxelize::LidarWorldOptions& options, util::StageTimes& times, std::size_t image_bytes);

}  // namespace terravox::module
