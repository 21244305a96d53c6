#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace terravox::laz {

/// The header as one JSON object: path, bytes, version, point_format, compressed, copc, lax,
/// point_count, scale, offset, min, max, crs ("EPSG:n" or null), crs_name, colour, near_infrared.
/// Reads no points.
/// @throws Error for a file that is not a point cloud or is truncated
[[nodiscard]] std::string info_json(const std::filesystem::path& path);

/// Validates a file by decoding every field of every point. A point may lie one step of the scale
/// beyond the header's bounds, since writers round them.
/// @return number of points
/// @throws Error when the file is damaged, has no points, or a point lies outside the bounds of its
/// header
std::uint64_t check(const std::filesystem::path& path);

}  // namespace terravox::laz
