#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "voxelserver/data/lidar/las_file.hpp"

namespace terravox::laz {

struct Compressed {
    std::uint64_t points = 0;
    std::uint64_t bytes_before = 0;
    std::uint64_t bytes_after = 0;
};

/// Compresses a LAS file (1.0-1.4, point formats 0-10) losslessly to LAZ: header, variable-length
/// records, points, and the data after the points (extended records, waveforms) with its offsets
/// corrected. The result is read back and compared point by point before it appears under its name;
/// on failure nothing is left there. Memory use does not depend on the size of the file.
/// @throws UsageError when both names are one file; Error for a file that is damaged, already
/// compressed or without points, and when the result cannot be written or differs
[[nodiscard]] Compressed compress(const std::filesystem::path& from,
                                  const std::filesystem::path& to);

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

struct Indexed {
    std::filesystem::path path;
    std::uint64_t bytes = 0;
    std::uint64_t cells = 0;
    std::uint64_t intervals = 0;
};

/// Writes the .lax file next to a point cloud: a quadtree whose cells hold intervals of points. The
/// file appears atomically, after it has been read back. Memory is bounded for any order of the
/// points: intervals of a cell are merged when there are too many. Ref: Isenburg, "LASindex -
/// simple spatial indexing of LiDAR data", European LiDAR Mapping Forum 2012.
/// @throws Error for a damaged file, one without points, one with a COPC hierarchy (its own index),
/// or a result that cannot be written
[[nodiscard]] Indexed write_lax(const std::filesystem::path& cloud);

}  // namespace terravox::laz
