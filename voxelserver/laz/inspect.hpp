#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace terravox::laz {

/// What the header says, as one JSON object: path, bytes, version, point_format, compressed, copc,
/// lax, point_count, scale, offset, min, max, crs ("EPSG:n" or null), crs_name, colour,
/// near_infrared. Touches no point.
/// @throws Error for a file that is no point cloud or cut short
[[nodiscard]] std::string info_json(const std::filesystem::path& path);

/// Decodes every field of every point. A point may lie one step of the scale beyond the header's
/// bounds, since writers round them.
/// @return number of points
/// @throws Error when the file is damaged, has no points, or a point lies outside the bounds of its
/// header
std::uint64_t check(const std::filesystem::path& path);

}  // namespace terravox::laz
