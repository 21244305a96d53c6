#pragma once

#include <filesystem>
#include <vector>

#include "voxelserver/voxelize/lidar_world.hpp"

namespace terravox::voxelize {

/// The files that options name, and those in the folders that they name, by path. @throws
/// UsageError when there are none
[[nodiscard]] std::vector<std::filesystem::path> lidar_files(const LidarWorldOptions& options);

/// The images that paths name, and those in the folders that they name. @throws UsageError for a
/// path that is not there
[[nodiscard]] std::vector<std::filesystem::path> orthophoto_files(
    const std::vector<std::filesystem::path>& paths);

}  // namespace terravox::voxelize
