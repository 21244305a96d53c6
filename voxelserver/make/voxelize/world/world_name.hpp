#pragma once

#include <string>

#include "voxelserver/make/voxelize/points/options.hpp"

namespace terravox::voxelize {

/// A name (32 hexadecimal digits) for everything that opening a world reads: options, the values of
/// class table, settings and palette, and of every LiDAR file and orthophoto its path, size, time,
/// beginning and end. Worlds of one name have the same facts. Memory, threads and cache folder are
/// not part of it. Costs some 50 microseconds a file; needs no library that reads them.
/// @param opener the file that holds the code that opens worlds (module/), since another version
/// may open them differently; empty = it is not part of the name
/// @throws what open_lidar_world throws for missing files and bad tables
[[nodiscard]] std::string world_name(const LidarWorldOptions& options,
                                     const std::filesystem::path& opener = {});

}  // namespace terravox::voxelize
