#pragma once

#include <filesystem>
#include <vector>

#include "voxelserver/make/voxelize/points/options.hpp"

namespace terravox::voxelize {

/// The point files that the options name, and those in the folders that they name, sorted by path.
/// Without those that the options leave out.
/// @throws UsageError when there are none
[[nodiscard]] std::vector<std::filesystem::path> lidar_files(const LidarWorldOptions& options);

}  // namespace terravox::voxelize
