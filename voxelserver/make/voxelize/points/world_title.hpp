#pragma once

#include <string>

#include "voxelserver/make/voxelize/points/options.hpp"

namespace terravox::voxelize {

/// The title of a world: that of the options; else the name of its only input, or of the folder in
/// which all of its inputs lie; else the name of the first one, and how many more there are.
[[nodiscard]] std::string world_title(const LidarWorldOptions& options);

}  // namespace terravox::voxelize
