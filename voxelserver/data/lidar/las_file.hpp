#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "voxelserver/data/pointcloud/point.hpp"
#include "voxelserver/data/pointcloud/point_source.hpp"

namespace terravox::lidar {

struct ChunkTable;

/// Offsets, within the extra bytes of a point, of the fields that the older point format lacks
/// (las_header.hpp).
struct CompatibleBytes {
    std::uint32_t returns = 0;
    std::uint32_t classification = 0;
    std::uint32_t flags = 0;
    std::optional<std::uint32_t> near_infrared;
};

/// The header of a LAS or LAZ file, checked against the file's size. Coordinates are the file's
/// own.
struct LasInfo : pointcloud::PointCloudInfo {
    int version_minor = 2;  ///< LAS 1.x
    int point_format = 0;   ///< 0-10
    bool compressed = false;
    /// Whether chunks can be decoded independently, so that several readers can work in parallel.
    bool seekable = true;
    /// Points per chunk; an estimate for uncompressed files and those with chunks of varying size.
    std::uint32_t chunk_points = 50000;
    /// The actual beginnings of the chunks (chunk_table.hpp); null unless compressed, seekable and
    /// not empty.
    std::shared_ptr<const ChunkTable> chunks;
    /// Set for formats 6-10 stored within an older one; points are then returned as in the former.
    std::optional<CompatibleBytes> compatible;
    [[nodiscard]] bool has_colour() const noexcept {
        return point_format == 2 || point_format == 3 || point_format == 5 || point_format == 7 ||
               point_format == 8 || point_format == 10;
    }
    [[nodiscard]] bool has_near_infrared() const noexcept {
        return point_format == 8 || point_format == 10 || (compatible && compatible->near_infrared);
    }
};

using pointcloud::PointRange;

/// One return as stored in the file: coordinates are info.scale * X + info.offset.
struct RawPoint {
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t z = 0;
    std::uint8_t classification = 0;  ///< all 8 bits for formats 6-10; the 5 bits of older formats
    std::uint8_t return_number = 1;
    std::uint8_t return_count = 1;
    bool withheld = false;
    bool overlap = false;
    std::array<std::uint16_t, 3> rgb{};  ///< 0 when the format has no colour
    std::uint16_t nir = 0;           ///< 0 when the format has no near infrared (only 8 and 10 do)
    std::uint16_t intensity = 0;     ///< of the echo; 0 when the scanner recorded none
    std::uint16_t point_source = 0;  ///< number of the flight line; 0 = not known
    [[nodiscard]] bool operator==(const RawPoint&) const = default;
};

/// Whether the intensities and flight lines of points are wanted.
enum class Echoes : std::uint8_t { kRead, kSkip };

/// Receives points in batches of 1 to 4096, in file order; the span is valid during the call only.
using RawBatchSink = std::function<void(std::span<const RawPoint>)>;

/// Reads and checks the header and the variable-length records; reads no points.
/// @throws Error for a missing file, one that is not LAS/LAZ, a truncated one, or one whose header
/// claims more than the file can hold
[[nodiscard]] LasInfo read_las_info(const std::filesystem::path& path);

/// Splits a file into ranges that start at chunk boundaries, so that each can be decoded by a
/// separate reader.
[[nodiscard]] std::vector<PointRange> split_by_chunk(const LasInfo& info,
                                                     std::uint64_t points_per_range);

/// Decodes the points of the ranges in the given order. Each call uses its own LASzip reader, which
/// seeks between ranges; may be called from any number of threads. A range that starts inside a
/// chunk also costs decoding the preceding points of that chunk. Where the format allows it (6-10),
/// only coordinates, returns, classification, flags, intensity, flight line, colour and near
/// infrared are decompressed; angles and times are not.
/// @param ranges within [0, info.point_count]; empty ones are skipped
/// @throws Error when the file is damaged or truncated, or a range ends beyond it; the sink may
/// have been called for earlier points
/// @param echoes kSkip leaves intensity and flight line 0 where that saves time (formats 6-10)
void read_point_batches(const LasInfo& info, std::span<const PointRange> ranges,
                        const RawBatchSink& sink, Echoes echoes = Echoes::kRead);

/// A deterministic sample spread over the file: the first points of up to 64 evenly spaced chunks,
/// in file order, or every n-th point of the root node of a COPC file (of its first 100,000). For a
/// file that is not seekable, its first points.
/// @param about  approximate number of points; at least one per chunk, at most all of the file
/// @throws Error as read_point_batches; and for a damaged COPC hierarchy
[[nodiscard]] std::vector<RawPoint> sample_points(const LasInfo& info, std::size_t about);

}  // namespace terravox::lidar
