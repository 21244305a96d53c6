#pragma once

#include <optional>
#include <vector>

#include "voxelserver/data/lidar/las_file.hpp"
#include "voxelserver/data/lidar/records.hpp"

namespace terravox::lidar {

/// Points of formats 6-10 can be stored in the older formats 1, 3, 4 and 5, so that old programs
/// can read them; the fields that these lack are stored in extra bytes of every point ("LAS 1.4
/// compatibility mode"). Ref: Isenburg, "LAS 1.4 compatibility mode for LASzip", 2014.
/// @return the offsets of these bytes, or nullopt when the file does not use this mode
/// @throws Error when its records are truncated
[[nodiscard]] std::optional<CompatibleBytes> find_compatible_bytes(
    const pointcloud::FileBytes& file, const std::vector<VariableRecord>& records, int point_format,
    std::uint32_t extra_bytes);

}  // namespace terravox::lidar
