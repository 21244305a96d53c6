#include "voxelserver/data/lidar/records.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <initializer_list>

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

std::uint32_t bytes_of(Part part) {
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
std::uint32_t layers_of(Part part, std::uint32_t bytes) {
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

std::vector<Part> parts_of(int format) {
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
    const auto wanted = parts_of(format);
    std::uint32_t layers = 0;
    std::uint32_t bytes = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint64_t at = record.at + kFixedBytes + kPartBytes * i;
        const auto type = file.at<std::uint16_t>(at);
        const auto size = file.at<std::uint16_t>(at + 2);
        const auto version = file.at<std::uint16_t>(at + 4);
        const Part part = i < wanted.size() ? wanted[i] : format >= 6 ? kExtra14 : kExtra;
        const bool right_size = bytes_of(part) == 0 ? size > 0 : size == bytes_of(part);
        if (i > wanted.size() || type != part || !right_size || !version_is_known(part, version))
            file.fail("LASzip's part " + std::to_string(i + 1) + " of a point (type " +
                      std::to_string(type) + ", " + std::to_string(size) + " bytes, version " +
                      std::to_string(version) + ") is none of point format " +
                      std::to_string(format));
        layers += layers_of(part, size);
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

}  // namespace terravox::lidar
