#pragma once

#include <string>
#include <string_view>

#include "voxelserver/make/voxelize/points/options.hpp"
#include "voxelserver/make/worlds/kind/world_kind.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"

namespace terravox::worlds {

// Checks of LiDAR inputs that do not need the libraries that read them.

/// Flags of `terravox serve` for LiDAR data and stores (WorldKind::flags).
inline constexpr std::string_view kLidarFlags =
    "--classes --mark-unknown --settings --steps --photo --crs --voxel --vertical-unit";

/// Files of points, for help and messages.
inline constexpr std::string_view kLidarInputs = "LAS, LAZ, COPC or PLY files";

/// Whether an input is such a file (by name or content), or a folder of them.
/// Throws nothing.
[[nodiscard]] bool is_lidar(const std::string& input);

/// Whether an input is a store that the grabber has filled. Throws nothing.
[[nodiscard]] bool is_store(const std::string& input);

/// All options except the files.
[[nodiscard]] voxelize::LidarWorldOptions lidar_options(const WorldOptions& from);

/// Files of points (pointcloud/formats), or folders of them.
extern const WorldKind kLidarKind;

/// A store that the grabber has filled.
extern const WorldKind kStoreKind;

/// All options of a world of either kind, with the files of its inputs.
/// @throws UsageError, Error for a store that cannot be read or holds nothing
[[nodiscard]] voxelize::LidarWorldOptions lidar_world_options(const WorldOptions& from);

}  // namespace terravox::worlds
