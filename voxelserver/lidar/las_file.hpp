#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "common/geo/crs.hpp"

namespace terravox::lidar {

/// What the header of a LAS or LAZ file says, checked against the file's size. Coordinates are the file's own.
struct LasInfo {
    std::filesystem::path path;
    std::uint64_t file_bytes = 0;
    int version_minor = 2;  ///< LAS 1.x
    int point_format = 0;   ///< 0-10
    bool compressed = false;
    bool seekable = true;  ///< chunks can be read on their own, so several readers help
    std::uint64_t point_count = 0;
    std::uint32_t chunk_points = 50000;  ///< points in a chunk (a guess for files with chunks of varying size)
    std::array<double, 3> scale{}, offset{};
    std::array<double, 3> min{}, max{};  ///< as the header states them, closed
    std::optional<geo::Crs> crs;         ///< from WKT or GeoTIFF keys, when the file carries any that can be understood
    [[nodiscard]] bool has_colour() const noexcept {
        return point_format == 2 || point_format == 3 || point_format == 5 || point_format == 7 || point_format == 8 || point_format == 10;
    }
};

/// One return, in file coordinates.
struct LasPoint {
    double x = 0, y = 0, z = 0;
    std::uint8_t classification = 0;  ///< all 8 bits for formats 6-10; the 5 bits of older formats
    std::uint8_t return_number = 1, return_count = 1;
    bool withheld = false, overlap = false;
    std::array<std::uint16_t, 3> rgb{};  ///< 0 when the format has none
};

/// A range of points of one file, half-open.
struct PointRange {
    std::uint64_t begin = 0, end = 0;
};

/// Reads and checks the header and the variable-length records; touches no point.
/// @throws Error for a missing file, one that is not LAS/LAZ, or one cut short or that claims more than it can hold
[[nodiscard]] LasInfo read_las_info(const std::filesystem::path& path);

/// Splits a file into ranges that start at chunk borders, so that each can be decoded by a reader of its own.
[[nodiscard]] std::vector<PointRange> split_by_chunk(const LasInfo& info, std::uint64_t points_per_range);

/// Decodes the points of a range in file order. One LASzip reader a call: call from as many threads as wanted.
/// Only coordinates, returns, classification, flags and colour are decompressed where the format allows (6-10).
/// @throws Error when the file is damaged or cut short; the sink may have been called for points before
void read_las_points(const LasInfo& info, PointRange range, const std::function<void(const LasPoint&)>& sink);

/// Decodes all points and drops them: the floor that any use of the file is measured against.
/// @return number of points
std::uint64_t decode_only(const LasInfo& info, int threads);

}  // namespace terravox::lidar
