#include "voxelserver/lidar/las_header.hpp"

#include <cmath>
#include <cstring>
#include <fstream>
#include <string>

#include "common/util/error.hpp"

namespace terravox::lidar {
namespace {

// Record lengths of point formats 0-10 without extra bytes. Ref: ASPRS, "LAS Specification 1.4 - R15", 2019.
constexpr std::array<int, 11> kRecordBytes = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
constexpr std::uint64_t kMostPoints = 20'000'000'000;  // a survey square has less than a tenth of this
constexpr std::uint32_t kVariableChunks = 0xFFFFFFFF;

class Bytes {
public:
    explicit Bytes(const std::filesystem::path& path) : m_path(path) {
        std::error_code failed;
        if (!std::filesystem::exists(path, failed)) fail("no such file");
        if (!std::filesystem::is_regular_file(path, failed)) fail("not a regular file");
        m_size = std::filesystem::file_size(path, failed);
        if (failed) fail(failed.message());
        m_stream.open(path, std::ios::binary);
        if (!m_stream) fail("cannot be opened for reading");
    }
    [[noreturn]] void fail(const std::string& what) const { throw Error("read the point cloud " + m_path.string() + ": " + what); }
    [[nodiscard]] std::uint64_t size() const noexcept { return m_size; }
    template <class T> T at(std::uint64_t offset) {
        T value;
        if (offset + sizeof value > m_size) fail("cut short: " + std::to_string(m_size) + " bytes, but a field is expected at byte " + std::to_string(offset));
        m_stream.seekg(static_cast<std::streamoff>(offset));
        m_stream.read(reinterpret_cast<char*>(&value), sizeof value);
        if (!m_stream) fail("read error at byte " + std::to_string(offset));
        return value;
    }

private:
    std::filesystem::path m_path;
    std::uint64_t m_size = 0;
    std::ifstream m_stream;
};

struct LaszipRecord {
    std::uint16_t compressor = 0;
    std::uint32_t chunk_points = 0;
};

// Walks the variable-length records and returns LASzip's own. Ref: Isenburg, "LASzip", 2013, and its VLR 22204.
std::optional<LaszipRecord> walk_records(Bytes& bytes, std::uint64_t header_bytes, std::uint64_t points_at, std::uint32_t count) {
    constexpr std::uint64_t kRecordHeader = 54;
    std::optional<LaszipRecord> found;
    std::uint64_t at = header_bytes;
    if (count * kRecordHeader > points_at - header_bytes)
        bytes.fail(std::to_string(count) + " variable-length records; the " + std::to_string(points_at - header_bytes) + " bytes before the points hold at most " +
                   std::to_string((points_at - header_bytes) / kRecordHeader));
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto user = bytes.at<std::array<char, 16>>(at + 2);
        const auto id = bytes.at<std::uint16_t>(at + 18);
        const auto length = bytes.at<std::uint16_t>(at + 20);
        if (at + kRecordHeader + length > points_at) bytes.fail("variable-length record " + std::to_string(i + 1) + " runs into the points");
        if (id == 22204 && std::strncmp(user.data(), "laszip encoded", 16) == 0 && length >= 34)
            found = LaszipRecord{bytes.at<std::uint16_t>(at + kRecordHeader), bytes.at<std::uint32_t>(at + kRecordHeader + 12)};
        at += kRecordHeader + length;
        if (at + kRecordHeader > points_at && i + 1 < count) bytes.fail("variable-length record " + std::to_string(i + 2) + " runs into the points");
    }
    return found;
}

// Every chunk starts with one whole point, and there is a table of all chunks: both bound how many points there can be.
void check_chunks(Bytes& bytes, LasInfo& info, const LaszipRecord& record, std::uint64_t points_at, std::uint64_t record_bytes) {
    if (record.compressor < 1 || record.compressor > 3) bytes.fail("LASzip compressor " + std::to_string(record.compressor) + "; allowed: 1 to 3");
    info.seekable = record.compressor != 1;
    if (!info.seekable || info.point_count == 0) return;
    auto table_at = bytes.at<std::int64_t>(points_at);
    // A writer that could not seek back leaves -1 and puts the offset at the end of the file.
    if (table_at == -1) table_at = bytes.at<std::int64_t>(bytes.size() - 8);
    if (table_at < static_cast<std::int64_t>(points_at + 8) || static_cast<std::uint64_t>(table_at) + 8 > bytes.size())
        bytes.fail("cut short or damaged: its chunk table should be at byte " + std::to_string(table_at) + " of " + std::to_string(bytes.size()));
    const auto chunks = bytes.at<std::uint32_t>(static_cast<std::uint64_t>(table_at) + 4);
    const std::uint64_t most_chunks = (static_cast<std::uint64_t>(table_at) - points_at - 8) / record_bytes;
    if (chunks == 0 || chunks > most_chunks)
        bytes.fail(std::to_string(chunks) + " chunks; the compressed points hold 1 to " + std::to_string(most_chunks));
    if (record.chunk_points == kVariableChunks) return;
    if (record.chunk_points == 0) bytes.fail("chunks of 0 points");
    info.chunk_points = record.chunk_points;
    if (info.point_count > std::uint64_t{chunks} * record.chunk_points)
        bytes.fail(std::to_string(info.point_count) + " points; its " + std::to_string(chunks) + " chunks hold at most " +
                   std::to_string(std::uint64_t{chunks} * record.chunk_points));
}

}  // namespace

LasInfo check_las_header(const std::filesystem::path& path) {
    Bytes bytes(path);
    constexpr std::uint64_t kSmallestHeader = 227;
    if (bytes.size() < 4 || bytes.at<std::array<char, 4>>(0) != std::array<char, 4>{'L', 'A', 'S', 'F'}) bytes.fail("not a LAS or LAZ file (it does not start with 'LASF')");
    if (bytes.size() < kSmallestHeader) bytes.fail("cut short: " + std::to_string(bytes.size()) + " bytes; a header has at least 227");
    LasInfo info;
    info.path = path;
    info.file_bytes = bytes.size();
    const int major = bytes.at<std::uint8_t>(24);
    info.version_minor = bytes.at<std::uint8_t>(25);
    if (major != 1 || info.version_minor > 4) bytes.fail("LAS version " + std::to_string(major) + "." + std::to_string(info.version_minor) + "; allowed: 1.0 to 1.4");
    const std::uint64_t header_bytes = bytes.at<std::uint16_t>(94), points_at = bytes.at<std::uint32_t>(96);
    const std::uint64_t least = info.version_minor == 4 ? 375 : info.version_minor == 3 ? 235 : kSmallestHeader;
    if (header_bytes < least || points_at < header_bytes || points_at > bytes.size())
        bytes.fail("header of " + std::to_string(header_bytes) + " bytes and points at byte " + std::to_string(points_at) + " of " + std::to_string(bytes.size()));
    const auto format_byte = bytes.at<std::uint8_t>(104);
    info.compressed = (format_byte & 0xC0) != 0;
    info.point_format = format_byte & 0x3F;
    if (info.point_format > 10) bytes.fail("point format " + std::to_string(info.point_format) + "; allowed: 0 to 10");
    const std::uint64_t record_bytes = bytes.at<std::uint16_t>(105);
    const int needed = kRecordBytes[static_cast<std::size_t>(info.point_format)];
    if (record_bytes < static_cast<std::uint64_t>(needed)) bytes.fail("point records of " + std::to_string(record_bytes) + " bytes; format " + std::to_string(info.point_format) + " needs " + std::to_string(needed));
    info.point_count = bytes.at<std::uint32_t>(107);
    if (info.version_minor == 4) {
        const auto count = bytes.at<std::uint64_t>(247);
        if (count != 0) info.point_count = count;
    }
    if (info.point_count > kMostPoints) bytes.fail(std::to_string(info.point_count) + " points; allowed: up to " + std::to_string(kMostPoints));
    for (std::size_t axis = 0; axis < 3; ++axis) {
        info.scale[axis] = bytes.at<double>(131 + 8 * axis);
        info.offset[axis] = bytes.at<double>(155 + 8 * axis);
        info.max[axis] = bytes.at<double>(179 + 16 * axis);
        info.min[axis] = bytes.at<double>(187 + 16 * axis);
        if (!(std::isfinite(info.scale[axis]) && info.scale[axis] > 0 && std::isfinite(info.offset[axis])))
            bytes.fail("scale " + std::to_string(info.scale[axis]) + " and offset " + std::to_string(info.offset[axis]) + "; allowed: finite, scale above 0");
        if (!std::isfinite(info.min[axis]) || !std::isfinite(info.max[axis])) bytes.fail("bounds are not finite numbers");
    }
    const auto laszip = walk_records(bytes, header_bytes, points_at, bytes.at<std::uint32_t>(100));
    if (info.compressed) {
        if (!laszip) bytes.fail("compressed, but without LASzip's record");
        check_chunks(bytes, info, *laszip, points_at, record_bytes);
    } else if (info.point_count > (bytes.size() - points_at) / record_bytes) {
        bytes.fail("cut short: " + std::to_string(info.point_count) + " points promised; " + std::to_string((bytes.size() - points_at) / record_bytes) + " are there");
    }
    return info;
}

}  // namespace terravox::lidar
