#include "voxelserver/data/lidar/las_header.hpp"

#include <cmath>
#include <string>

#include "voxelserver/data/lidar/chunk_table.hpp"
#include "voxelserver/data/lidar/compatible.hpp"
#include "voxelserver/data/lidar/records.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"

namespace terravox::lidar {
namespace {

// Record lengths of point formats 0-10 without extra bytes. Ref: ASPRS, "LAS Specification 1.4 -
// R15", 2019.
constexpr std::array<std::uint32_t, 11> kRecordBytes = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
// LASzip seeks with 32 bits; a survey square has less than a tenth of this.
constexpr std::uint64_t kMaxPoints = 0xFFFFFFFF;

struct Layout {
    std::uint64_t points_at = 0;
    std::uint32_t record_bytes = 0;
};

void check_version(const pointcloud::FileBytes& bytes, LasInfo& info) {
    constexpr std::uint64_t kSmallestHeader = 227;
    constexpr std::array<char, 4> kSignature = {'L', 'A', 'S', 'F'};
    if (bytes.size() < kSignature.size() || bytes.at<std::array<char, 4>>(0) != kSignature)
        bytes.fail("not a LAS or LAZ file (it does not start with 'LASF')");
    if (bytes.size() < kSmallestHeader)
        bytes.fail("cut short: " + std::to_string(bytes.size()) +
                   " bytes; a header has at least 227");
    const int major = bytes.at<std::uint8_t>(24);
    info.version_minor = bytes.at<std::uint8_t>(25);
    if (major != 1 || info.version_minor > 4)
        bytes.fail("LAS version " + std::to_string(major) + "." +
                   std::to_string(info.version_minor) + "; allowed: 1.0 to 1.4");
    const std::uint64_t header_bytes = bytes.at<std::uint16_t>(94);
    const std::uint64_t points_at = bytes.at<std::uint32_t>(96);
    const std::uint64_t min_header_bytes = info.version_minor == 4   ? 375
                                           : info.version_minor == 3 ? 235
                                                                     : kSmallestHeader;
    if (header_bytes < min_header_bytes || points_at < header_bytes || points_at > bytes.size())
        bytes.fail("header of " + std::to_string(header_bytes) + " bytes and points at byte " +
                   std::to_string(points_at) + " of " + std::to_string(bytes.size()));
}

Layout check_format(const pointcloud::FileBytes& bytes, LasInfo& info) {
    const auto format_byte = bytes.at<std::uint8_t>(104);
    info.compressed = (format_byte & 0xC0) != 0;
    info.point_format = format_byte & 0x3F;
    if (info.point_format > 10)
        bytes.fail("point format " + std::to_string(info.point_format) + "; allowed: 0 to 10");
    const std::uint32_t record_bytes = bytes.at<std::uint16_t>(105);
    const std::uint32_t needed = kRecordBytes[static_cast<std::size_t>(info.point_format)];
    if (record_bytes < needed)
        bytes.fail("point records of " + std::to_string(record_bytes) + " bytes; format " +
                   std::to_string(info.point_format) + " needs " + std::to_string(needed));
    info.point_count = bytes.at<std::uint32_t>(107);
    if (info.version_minor == 4) {
        const auto count = bytes.at<std::uint64_t>(247);
        if (count != 0)
            info.point_count = count;
    }
    if (info.point_count > kMaxPoints)
        bytes.fail(std::to_string(info.point_count) + " points; allowed: up to " +
                   std::to_string(kMaxPoints));
    return {bytes.at<std::uint32_t>(96), record_bytes};
}

void check_frame(const pointcloud::FileBytes& bytes, LasInfo& info) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        info.scale[axis] = bytes.at<double>(131 + 8 * axis);
        info.offset[axis] = bytes.at<double>(155 + 8 * axis);
        info.max[axis] = bytes.at<double>(179 + 16 * axis);
        info.min[axis] = bytes.at<double>(187 + 16 * axis);
        if (!(std::isfinite(info.scale[axis]) && info.scale[axis] > 0 &&
              std::isfinite(info.offset[axis])))
            bytes.fail("scale " + std::to_string(info.scale[axis]) + " and offset " +
                       std::to_string(info.offset[axis]) + "; allowed: finite, scale above 0");
        if (!std::isfinite(info.min[axis]) || !std::isfinite(info.max[axis]))
            bytes.fail("bounds are not finite numbers");
    }
}

void check_compressed(const pointcloud::FileBytes& bytes, LasInfo& info, const LaszipRecord& record,
                      Layout layout) {
    info.seekable = record.compressor != LaszipRecord::kPointwise;
    // Damaged files may claim billions of points in a few bytes. The coder uses at least a few
    // hundredths of a bit per symbol: with identical points one byte holds at most 148 of them
    // (format 0; 133 in format 1, 96 in format 6), whatever the length of their record.
    constexpr std::uint64_t kMaxAByte = 200;
    constexpr std::uint64_t kAlwaysAllowed = 1'000'000;
    const std::uint64_t max_points = (bytes.size() - layout.points_at) * kMaxAByte + kAlwaysAllowed;
    if (info.point_count > max_points)
        bytes.fail(std::to_string(info.point_count) + " points; the compressed ones hold at most " +
                   std::to_string(max_points));
    if (!info.seekable)
        return;
    if (info.point_count == 0)
        return;
    info.chunks = std::make_shared<const ChunkTable>(
        read_chunk_table(bytes, record, layout.points_at, info.point_count, layout.record_bytes));
    if (record.chunk_points != LaszipRecord::kVariableChunks)
        info.chunk_points = record.chunk_points;
}

}  // namespace

LasInfo check_las_header(const std::filesystem::path& path) {
    const pointcloud::FileBytes bytes(path);
    LasInfo info;
    info.path = path;
    info.file_bytes = bytes.size();
    check_version(bytes, info);
    const Layout layout = check_format(bytes, info);
    check_frame(bytes, info);
    const auto records = read_records(bytes);
    info.compatible = find_compatible_bytes(
        bytes, records, info.point_format,
        layout.record_bytes - kRecordBytes[static_cast<std::size_t>(info.point_format)]);
    const auto laszip = read_laszip_record(bytes, records, info.point_format, layout.record_bytes);
    // LASzip decides by its own record alone: uncompressed points with such a record would be
    // decompressed into nonsense.
    if (info.compressed != laszip.has_value())
        bytes.fail(laszip ? "not compressed, but with LASzip's record"
                          : "compressed, but without LASzip's record");
    if (laszip) {
        check_compressed(bytes, info, *laszip, layout);
    } else if (const std::uint64_t held = (bytes.size() - layout.points_at) / layout.record_bytes;
               info.point_count > held) {
        bytes.fail("cut short: " + std::to_string(info.point_count) + " points promised; " +
                   std::to_string(held) + " are there");
    }
    return info;
}

}  // namespace terravox::lidar
