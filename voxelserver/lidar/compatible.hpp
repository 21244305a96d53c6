#pragma once

#include <optional>
#include <vector>

#include "voxelserver/lidar/las_file.hpp"
#include "voxelserver/lidar/records.hpp"

namespace terravox::lidar {

/// Points of formats 6-10 can be kept in the older formats 1, 3, 4 and 5, so that old programs read
/// them; what does not fit there stands in extra bytes of every point ("LAS 1.4 compatibility
/// mode"). Ref: Isenburg, "LAS 1.4 compatibility mode for LASzip", 2014.
/// @return where these bytes stand, or nullopt when this is no such file
/// @throws Error when its records are cut short
[[nodiscard]] std::optional<CompatibleBytes> find_compatible_bytes(
    const pointcloud::FileBytes& file, const std::vector<VariableRecord>& records, int point_format,
    std::uint32_t extra_bytes);

}  // namespace terravox::lidar
