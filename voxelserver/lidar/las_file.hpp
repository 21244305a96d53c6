#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/geo/crs.hpp"
#include "voxelserver/pointcloud/point.hpp"

namespace terravox::lidar {

struct ChunkTable;

/// Where the extra bytes of an old format hold what does not fit it (compatible.hpp): offsets
/// within the extra bytes of a point.
struct CompatibleBytes {
    std::uint32_t returns = 0, classification = 0, flags = 0;
    std::optional<std::uint32_t> near_infrared;
};

/// What the header of a LAS or LAZ file says, checked against the file's size. Coordinates are the
/// file's own.
struct LasInfo {
    std::filesystem::path path;
    std::uint64_t file_bytes = 0;
    int version_minor = 2;  ///< LAS 1.x
    int point_format = 0;   ///< 0-10
    bool compressed = false;
    bool seekable = true;  ///< chunks can be read on their own, so several readers help
    std::uint64_t point_count = 0;
    std::uint32_t chunk_points = 50000;  ///< points in a chunk (a guess for plain files and those
                                         ///< with chunks of varying size)
    std::shared_ptr<const ChunkTable> chunks;  ///< where the chunks really begin (chunk_table.hpp);
                                               ///< null unless compressed, seekable and not empty
    std::optional<CompatibleBytes>
        compatible;  ///< formats 6-10 within an older one: points are given as those formats say
    std::array<double, 3> scale{}, offset{};
    std::array<double, 3> min{}, max{};  ///< as the header states them, closed
    std::optional<geo::Crs>
        crs;  ///< from WKT or GeoTIFF keys, when the file carries any that can be understood
    [[nodiscard]] bool has_colour() const noexcept {
        return point_format == 2 || point_format == 3 || point_format == 5 || point_format == 7 ||
               point_format == 8 || point_format == 10;
    }
    [[nodiscard]] bool has_near_infrared() const noexcept {
        return point_format == 8 || point_format == 10 || (compatible && compatible->near_infrared);
    }
};

using pointcloud::PointRange;

/// One return as the file stores it: coordinates are info.scale * X + info.offset.
struct RawPoint {
    std::int32_t x = 0, y = 0, z = 0;
    std::uint8_t classification = 0;  ///< all 8 bits for formats 6-10; the 5 bits of older formats
    std::uint8_t return_number = 1, return_count = 1;
    bool withheld = false, overlap = false;
    std::array<std::uint16_t, 3> rgb{};  ///< 0 when the format has none
    std::uint16_t nir = 0;               ///< 0 when the format (8, 10 have it) has none
    [[nodiscard]] bool operator==(const RawPoint&) const = default;
};

/// Takes points in batches of 1 to 4096, in file order; the span is valid during the call only.
using RawBatchSink = std::function<void(std::span<const RawPoint>)>;

/// Reads and checks the header and the variable-length records; touches no point.
/// @throws Error for a missing file, one that is not LAS/LAZ, or one cut short or that claims more
/// than it can hold
[[nodiscard]] LasInfo read_las_info(const std::filesystem::path& path);

/// Splits a file into ranges that start at chunk borders, so that each can be decoded by a reader
/// of its own.
[[nodiscard]] std::vector<PointRange> split_by_chunk(const LasInfo& info,
                                                     std::uint64_t points_per_range);

/// Decodes the points of the ranges in the order given. One LASzip reader a call, which seeks
/// between ranges: call from as many threads as wanted. A range that starts inside a chunk costs
/// the points of that chunk before it. Only coordinates, returns, classification, flags, colour and
/// near infrared are decompressed where the format allows (6-10); intensities, angles and times
/// stay packed.
/// @param ranges within [0, info.point_count]; empty ones are skipped
/// @throws Error when the file is damaged or cut short, or a range ends beyond it; the sink may
/// have been called for points before
void read_point_batches(const LasInfo& info, std::span<const PointRange> ranges,
                        const RawBatchSink& sink);

/// read_point_batches for one range, point by point in file coordinates: handy where speed does not
/// matter.
/// @throws Error when the file is damaged or cut short; the sink may have been called for points
/// before
void read_las_points(const LasInfo& info, PointRange range,
                     const std::function<void(const pointcloud::Point&)>& sink);

/// A deterministic sample spread over the file: the first points of up to 64 evenly spaced chunks,
/// in file order, or every n-th point of the root node of a COPC file (of its first 100,000). A
/// file that is not seekable gives its first points.
/// @param about  how many; at least one a chunk, at most all there are
/// @throws Error as read_point_batches; and for a damaged COPC hierarchy
[[nodiscard]] std::vector<RawPoint> sample_points(const LasInfo& info, std::size_t about);

/// Decodes all points and drops them: the floor that any use of the file is measured against.
/// @return number of points
std::uint64_t decode_only(const LasInfo& info, int threads);

}  // namespace terravox::lidar
