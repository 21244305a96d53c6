#pragma once

#include <optional>
#include <span>
#include <vector>

#include "voxelserver/data/grid/square_names.hpp"
#include "voxelserver/data/pointcloud/point_source.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/points/options.hpp"
#include "voxelserver/make/voxelize/points/placer.hpp"

namespace terravox::voxelize {

/// Gives files without a CRS of their own the one that a store has recorded of them
/// (LidarWorldOptions::recorded_crs).
/// @throws UsageError for a record that is no CRS
void use_recorded_crs(std::vector<SquareSource>& files, const LidarWorldOptions& options);

/// The square of a source that each file's name states; nullopt where it states none, or where the
/// points do not lie on that square. Nothing is looked up where nobody needs it: with a CRS for
/// each file, without images, and with a class table that the options name.
/// @throws UsageError for a file of config/sources that cannot be read
[[nodiscard]] std::vector<std::optional<grid::NamedSquare>> list_squares(
    const std::vector<SquareSource>& files, const LidarWorldOptions& options);

/// Sets each file's CRS: the user's option, else the one that it has (its own, or as recorded),
/// else that of the source whose names look like the file's, else that of the class table that the
/// options name. Logs
/// what names have decided.
/// @param squares of each file
/// @throws UsageError where a file has none of them
void settle_crs(std::vector<SquareSource>& files, const LidarWorldOptions& options,
                const std::vector<std::optional<grid::NamedSquare>>& squares);

/// Logs a one-line warning when files of one world measure heights from different datums: heights
/// are used as they are, so where such files meet there may be a step that is not in the land.
/// Files that name no datum are ignored.
/// @param infos each with the CRS in which its points will be read
void warn_of_mixed_datums(std::span<const pointcloud::PointCloudInfo> infos);

}  // namespace terravox::voxelize
