#include "voxelserver/data/lidar/las_header.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "common/util/log.hpp"
#include "voxelserver/data/lidar/chunk_table.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"

namespace terravox::lidar {
namespace {

// Parts of a point in LASzip's numbering, with the size of each in bytes; 0 = variable.
enum Part : std::uint16_t {
    kExtra = 0,
    kPoint = 6,
    kTime = 7,
    kRgb = 8,
    kWave = 9,
    kPoint14 = 10,
    kRgb14 = 11,
    kRgbNir14 = 12,
    kWave14 = 13,
    kExtra14 = 14
};

std::uint32_t measure_bytes(Part part) {
    switch (part) {
        case kPoint: return 20;
        case kPoint14: return 30;
        case kTime:
        case kRgbNir14: return 8;
        case kRgb:
        case kRgb14: return 6;
        case kWave:
        case kWave14: return 29;
        default: return 0;
    }
}

// Layers of coordinates, classes, flags, intensity, angle, user data, source and time; then one for
// each band and each extra byte.
std::uint32_t find_layers(Part part, std::uint32_t bytes) {
    switch (part) {
        case kPoint14: return 9;
        case kRgbNir14: return 2;
        case kRgb14:
        case kWave14: return 1;
        case kExtra14: return bytes;
        default: return 0;
    }
}

bool version_is_known(Part part, std::uint16_t version) {
    if (part == kWave)
        return version == 1;
    if (part == kWave14)
        return version == 3 || version == 4;
    return part >= kPoint14 ? version >= 2 && version <= 4 : version == 1 || version == 2;
}

std::vector<Part> list_parts(int format) {
    static const std::array<std::vector<Part>, 11> kParts = {{{kPoint},
                                                              {kPoint, kTime},
                                                              {kPoint, kRgb},
                                                              {kPoint, kTime, kRgb},
                                                              {kPoint, kTime, kWave},
                                                              {kPoint, kTime, kRgb, kWave},
                                                              {kPoint14},
                                                              {kPoint14, kRgb14},
                                                              {kPoint14, kRgbNir14},
                                                              {kPoint14, kWave14},
                                                              {kPoint14, kRgbNir14, kWave14}}};
    return kParts[static_cast<std::size_t>(format)];
}

// LASzip fills its point by these parts regardless of the point format, and crashes on some
// versions that it recognises but cannot read.
std::uint32_t check_parts(const pointcloud::FileBytes& file, const VariableRecord& record,
                          int format, std::uint32_t record_bytes) {
    constexpr std::uint64_t kFixedBytes = 34;
    constexpr std::uint64_t kPartBytes = 6;
    const auto count = file.at<std::uint16_t>(record.at + 32);
    if (record.bytes != kFixedBytes + kPartBytes * count)
        file.fail("LASzip's record has " + std::to_string(record.bytes) + " bytes for " +
                  std::to_string(count) + " parts of a point");
    const auto wanted = list_parts(format);
    std::uint32_t layers = 0;
    std::uint32_t bytes = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint64_t at = record.at + kFixedBytes + kPartBytes * i;
        const auto type = file.at<std::uint16_t>(at);
        const auto size = file.at<std::uint16_t>(at + 2);
        const auto version = file.at<std::uint16_t>(at + 4);
        const Part part = i < wanted.size() ? wanted[i] : format >= 6 ? kExtra14 : kExtra;
        const bool right_size = measure_bytes(part) == 0 ? size > 0 : size == measure_bytes(part);
        if (i > wanted.size() || type != part || !right_size || !version_is_known(part, version))
            file.fail("LASzip's part " + std::to_string(i + 1) + " of a point (type " +
                      std::to_string(type) + ", " + std::to_string(size) + " bytes, version " +
                      std::to_string(version) + ") is none of point format " +
                      std::to_string(format));
        layers += find_layers(part, size);
        bytes += size;
    }
    if (count < wanted.size() || bytes != record_bytes)
        file.fail("LASzip's " + std::to_string(count) + " parts of a point have " +
                  std::to_string(bytes) + " bytes; a record has " + std::to_string(record_bytes));
    return layers;
}

}  // namespace

std::vector<VariableRecord> read_records(const pointcloud::FileBytes& file) {
    constexpr std::uint64_t kRecordHeader = 54;
    const std::uint64_t header_bytes = file.at<std::uint16_t>(94);
    const std::uint64_t points_at = file.at<std::uint32_t>(96);
    const auto count = file.at<std::uint32_t>(100);
    if (count * kRecordHeader > points_at - header_bytes)
        file.fail(std::to_string(count) + " variable-length records; the " +
                  std::to_string(points_at - header_bytes) +
                  " bytes before the points"
                  " hold at most " +
                  std::to_string((points_at - header_bytes) / kRecordHeader));
    std::vector<VariableRecord> out;
    std::uint64_t at = header_bytes;
    for (std::uint32_t i = 0; i < count; ++i) {
        VariableRecord record;
        if (at + kRecordHeader <= points_at) {
            const auto user = file.at<std::array<char, 16>>(at + 2);
            record = {std::string(user.data(), ::strnlen(user.data(), user.size())),
                      file.at<std::uint16_t>(at + 18), at + kRecordHeader,
                      file.at<std::uint16_t>(at + 20)};
        }
        at += kRecordHeader + record.bytes;
        if (at > points_at)
            file.fail("variable-length record " + std::to_string(i + 1) + " runs into the points");
        out.push_back(std::move(record));
    }
    return out;
}

std::vector<VariableRecord> read_extended_records(const pointcloud::FileBytes& file) {
    constexpr std::uint64_t kRecordHeader = 60;
    constexpr std::uint32_t kMaxRecords = 1024;
    std::vector<VariableRecord> out;
    if (file.at<std::uint8_t>(25) < 4)
        return out;
    std::uint64_t at = file.at<std::uint64_t>(235);
    const auto count = file.at<std::uint32_t>(243);
    for (std::uint32_t i = 0; i < std::min(count, kMaxRecords); ++i) {
        const bool begins = at <= file.size() && file.size() - at >= kRecordHeader;
        const std::uint64_t bytes = begins ? file.at<std::uint64_t>(at + 20) : 0;
        if (!begins || bytes > file.size() - at - kRecordHeader) {
            util::warn_of_file(
                file.path().string(),
                "an extended record runs beyond the end of the file; what lies there is left out",
                fmt::format("record {} of {}", i + 1, count));
            break;
        }
        const auto user = file.at<std::array<char, 16>>(at + 2);
        out.push_back({std::string(user.data(), ::strnlen(user.data(), user.size())),
                       file.at<std::uint16_t>(at + 18), at + kRecordHeader, bytes});
        at += kRecordHeader + bytes;
    }
    return out;
}

std::optional<LaszipRecord> read_laszip_record(const pointcloud::FileBytes& file,
                                               const std::vector<VariableRecord>& records,
                                               int point_format, std::uint32_t record_bytes) {
    const auto is_laszip = [](const VariableRecord& r) {
        return r.id == 22204 && r.user == "laszip encoded";
    };
    const auto found = std::find_if(records.begin(), records.end(), is_laszip);
    if (found == records.end())
        return std::nullopt;
    if (std::find_if(found + 1, records.end(), is_laszip) != records.end())
        file.fail("two records of LASzip");
    if (found->bytes < 34)
        file.fail("LASzip's record has " + std::to_string(found->bytes) + " bytes; it needs 34");
    LaszipRecord out;
    out.compressor = file.at<std::uint16_t>(found->at);
    out.chunk_points = file.at<std::uint32_t>(found->at + 12);
    const auto coder = file.at<std::uint16_t>(found->at + 2);
    const bool layered = point_format >= 6;
    const bool fits = layered ? out.compressor == LaszipRecord::kLayered
                              : out.compressor == LaszipRecord::kPointwise ||
                                    out.compressor == LaszipRecord::kChunked;
    if (!fits || coder != 0)
        file.fail("LASzip compressor " + std::to_string(out.compressor) + " and coder " +
                  std::to_string(coder) + "; allowed for point format " +
                  std::to_string(point_format) + ": " + (layered ? "3" : "1 and 2") +
                  " with coder 0");
    out.layers = check_parts(file, *found, point_format, record_bytes);
    return out;
}

namespace {

/// Size of the description of one extra-bytes field.
constexpr std::uint64_t kDescriptionBytes = 192;
constexpr std::uint32_t kNowhere = 0xFFFFFFFF;

// Bytes per value. Types 1-10 are scalars, 11-20 pairs and 21-30 triples of them; for type 0 the
// size is stored separately.
std::optional<std::uint32_t> value_bytes(std::uint8_t type, std::uint8_t reported) {
    constexpr std::array<std::uint32_t, 10> kBytes = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    if (type == 0)
        return reported;
    if (type > 3 * kBytes.size())
        return std::nullopt;
    return kBytes[(type - 1U) % kBytes.size()] * ((type - 1U) / kBytes.size() + 1);
}

}  // namespace

std::optional<CompatibleBytes> find_compatible_bytes(const pointcloud::FileBytes& file,
                                                     const std::vector<VariableRecord>& records,
                                                     int point_format, std::uint32_t extra_bytes) {
    const auto find = [&](const char* user, int id) {
        return std::find_if(records.begin(), records.end(),
                            [&](const VariableRecord& r) { return r.id == id && r.user == user; });
    };
    const bool can =
        point_format == 1 || point_format == 3 || point_format == 4 || point_format == 5;
    const auto descriptions = find("LASF_Spec", 4);
    if (!can || find("lascompatible", 22204) == records.end() || descriptions == records.end())
        return std::nullopt;
    std::uint32_t returns = kNowhere;
    std::uint32_t classification = kNowhere;
    std::uint32_t flags = kNowhere;
    std::uint32_t infrared = kNowhere;
    std::uint32_t at = 0;
    for (std::uint64_t i = 0; i < descriptions->bytes / kDescriptionBytes; ++i) {
        const std::uint64_t description = descriptions->at + i * kDescriptionBytes;
        const auto name = file.at<std::array<char, 32>>(description + 4);
        const std::string text(name.begin(), std::find(name.begin(), name.end(), '\0'));
        const auto bytes = value_bytes(file.at<std::uint8_t>(description + 2),
                                       file.at<std::uint8_t>(description + 3));
        if (!bytes)
            return std::nullopt;
        const auto take = [&](const char* wanted, std::uint32_t size, std::uint32_t& where) {
            if (text == wanted && at + size <= extra_bytes)
                where = at;
        };
        take("LAS 1.4 extended returns", 1, returns);
        take("LAS 1.4 classification", 1, classification);
        take("LAS 1.4 flags and channel", 1, flags);
        take("LAS 1.4 NIR band", 2, infrared);
        at += *bytes;
    }
    if (returns == kNowhere || classification == kNowhere || flags == kNowhere)
        return std::nullopt;
    return CompatibleBytes{returns, classification, flags,
                           infrared == kNowhere ? std::nullopt : std::optional(infrared)};
}

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
    if (bytes.size() == 0)
        bytes.fail("it is empty; fetch it again");
    if (bytes.size() < kSignature.size() || bytes.at<std::array<char, 4>>(0) != kSignature)
        bytes.fail("not a LAS or LAZ file (it does not start with 'LASF')");
    if (bytes.size() < kSmallestHeader)
        bytes.fail("cut short: " + std::to_string(bytes.size()) +
                   " bytes; a header has at least 227; fetch it again");
    const int major = bytes.at<std::uint8_t>(24);
    info.version_minor = bytes.at<std::uint8_t>(25);
    if (major != 1 || info.version_minor > 5)
        bytes.fail("LAS version " + std::to_string(major) + "." +
                   std::to_string(info.version_minor) + "; allowed: 1.0 to 1.5");
    const std::uint64_t header_bytes = bytes.at<std::uint16_t>(94);
    const std::uint64_t points_at = bytes.at<std::uint32_t>(96);
    constexpr std::array<std::uint64_t, 6> kHeaderBytes = {
        kSmallestHeader, kSmallestHeader, kSmallestHeader, 235, 375, 393};
    const std::uint64_t min_header_bytes =
        kHeaderBytes[static_cast<std::size_t>(info.version_minor)];
    if (points_at > bytes.size())
        bytes.fail("cut short or damaged: points at byte " + std::to_string(points_at) + " of " +
                   std::to_string(bytes.size()) + "; fetch it again");
    if (header_bytes < min_header_bytes || points_at < header_bytes)
        bytes.fail("header of " + std::to_string(header_bytes) + " bytes and points at byte " +
                   std::to_string(points_at) + " of " + std::to_string(bytes.size()));
}

Layout check_format(const pointcloud::FileBytes& bytes, LasInfo& info) {
    const auto format_byte = bytes.at<std::uint8_t>(104);
    info.compressed = (format_byte & 0xC0) != 0;
    info.point_format = format_byte & 0x3F;
    const int first_format = info.version_minor == 5 ? 6 : 0;
    if (info.point_format < first_format || info.point_format > 10)
        bytes.fail("point format " + std::to_string(info.point_format) + " in LAS 1." +
                   std::to_string(info.version_minor) +
                   "; allowed: " + std::to_string(first_format) + " to 10");
    const std::uint32_t record_bytes = bytes.at<std::uint16_t>(105);
    const std::uint32_t needed = kRecordBytes[static_cast<std::size_t>(info.point_format)];
    if (record_bytes < needed)
        bytes.fail("point records of " + std::to_string(record_bytes) + " bytes; format " +
                   std::to_string(info.point_format) + " needs " + std::to_string(needed));
    info.point_count = info.version_minor == 5 ? 0 : bytes.at<std::uint32_t>(107);
    if (info.version_minor >= 4) {
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
                   std::to_string(held) + " are there; fetch it again");
    }
    return info;
}

}  // namespace terravox::lidar
