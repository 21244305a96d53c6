#include "voxelserver/data/lidar/chunk_table.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "voxelserver/data/lidar/range_decoder.hpp"

namespace terravox::lidar {
namespace {

constexpr std::uint64_t kTableHeader = 8;  ///< version and number of chunks
/// Bytes before the first chunk: the offset of the table.
constexpr std::uint64_t kTableOffset = 8;
constexpr std::uint64_t kLayersBegin = 4;  ///< number of points, before the sizes of the layers
constexpr std::uint64_t kSizeBytes = 4;
/// Empty chunks take almost no bytes, so that the size of the file hardly limits their number.
constexpr std::uint64_t kMaxEmptyChunks = 65'536;

// Reads bytes sequentially, in blocks.
class ByteQueue {
public:
    ByteQueue(const pointcloud::FileBytes& file, std::uint64_t at) : m_file(file), m_at(at) {}
    std::uint8_t next() {
        if (m_used == m_count) {
            m_count = static_cast<std::size_t>(std::clamp<std::uint64_t>(
                m_file.size() - std::min(m_file.size(), m_at), 1, m_block.size()));
            m_file.read(m_at, {m_block.data(), m_count});
            m_at += m_count;
            m_used = 0;
        }
        return m_block[m_used++];
    }

private:
    const pointcloud::FileBytes& m_file;
    std::uint64_t m_at;
    std::array<unsigned char, 4096> m_block{};
    std::size_t m_used = 0;
    std::size_t m_count = 0;
};

std::uint64_t find_table(const pointcloud::FileBytes& file, std::uint64_t points_at) {
    auto at = file.at<std::int64_t>(points_at);
    // A writer that cannot seek back writes -1 here and the offset at the end of the file.
    if (at == -1)
        at = file.at<std::int64_t>(file.size() - 8);
    if (at < static_cast<std::int64_t>(points_at + kTableOffset) ||
        static_cast<std::uint64_t>(at) > file.size() - kTableHeader)
        file.fail("cut short or damaged: its chunk table should be at byte " + std::to_string(at) +
                  " of " + std::to_string(file.size()));
    return static_cast<std::uint64_t>(at);
}

// @return number of chunks: the number of those with points is limited by the size of the file
std::uint32_t check_claims(const pointcloud::FileBytes& file, const LaszipRecord& record,
                           std::uint64_t table_at, std::uint64_t max_chunks,
                           std::uint64_t point_count) {
    const auto version = file.at<std::uint32_t>(table_at);
    const auto chunks = file.at<std::uint32_t>(table_at + 4);
    if (version != 0)
        file.fail("chunk table of version " + std::to_string(version) + "; allowed: 0");
    if (chunks == 0 || max_chunks == 0 || chunks > max_chunks + kMaxEmptyChunks)
        file.fail(std::to_string(chunks) + " chunks; the compressed points hold 1 to " +
                  std::to_string(max_chunks) + ", and up to " + std::to_string(kMaxEmptyChunks) +
                  " may be empty");
    if (record.chunk_points == 0)
        file.fail("chunks of 0 points");
    const std::uint64_t max_points = std::uint64_t{chunks} * record.chunk_points;
    if (record.chunk_points != LaszipRecord::kVariableChunks && point_count > max_points)
        file.fail(std::to_string(point_count) + " points; its " + std::to_string(chunks) +
                  " chunks hold at most " + std::to_string(max_points));
    return chunks;
}

}  // namespace

std::size_t ChunkTable::chunk_of(std::uint64_t point) const noexcept {
    return static_cast<std::size_t>(
               std::upper_bound(first_point.begin(), first_point.end(), point) -
               first_point.begin()) -
           1;
}

ChunkTable read_chunk_table(const pointcloud::FileBytes& file, const LaszipRecord& record,
                            std::uint64_t points_at, std::uint64_t point_count,
                            std::uint32_t record_bytes) {
    const std::uint64_t table_at = find_table(file, points_at);
    const std::uint64_t min_bytes =
        record_bytes + (record.layers > 0 ? kLayersBegin + kSizeBytes * record.layers : 0);
    const std::uint32_t chunks = check_claims(
        file, record, table_at, (table_at - points_at - kTableOffset) / min_bytes, point_count);
    ChunkTable table;
    table.record_bytes = record_bytes;
    table.layers = record.layers;
    table.first_point.push_back(0);
    table.first_byte.push_back(points_at + kTableOffset);
    ByteQueue queue(file, table_at + kTableHeader);
    RangeDecoder decoder([&] { return queue.next(); });
    IntegerDecoder numbers(decoder);
    const bool variable = record.chunk_points == LaszipRecord::kVariableChunks;
    std::int32_t points = 0;
    std::int32_t bytes = 0;
    for (std::uint32_t i = 0; i < chunks; ++i) {
        const std::uint64_t points_left = point_count - table.first_point.back();
        const std::uint64_t bytes_left = table_at - table.first_byte.back();
        if (variable)
            points = numbers.next(points, 0);
        bytes = numbers.next(bytes, 1);
        const std::int64_t mine = variable ? points
                                           : static_cast<std::int64_t>(std::min<std::uint64_t>(
                                                 record.chunk_points, points_left));
        const auto fail = [&](std::int64_t value, const char* what, std::uint64_t least,
                              std::uint64_t most) {
            file.fail("damaged chunk table: chunk " + std::to_string(i) + " of " +
                      std::to_string(value) + what + "; allowed: " + std::to_string(least) +
                      " to " + std::to_string(most));
        };
        if (mine < 0 || static_cast<std::uint64_t>(mine) > points_left)
            fail(mine, " points", 0, points_left);
        // LASzip treats a chunk that ends where it begins as damage, and reads nothing of the file.
        const std::uint64_t least = mine == 0 ? 1 : min_bytes;
        if (bytes < 0 || static_cast<std::uint64_t>(bytes) < least ||
            static_cast<std::uint64_t>(bytes) > bytes_left)
            fail(bytes, " bytes", least, bytes_left);
        table.first_point.push_back(table.first_point.back() + static_cast<std::uint64_t>(mine));
        table.first_byte.push_back(table.first_byte.back() + static_cast<std::uint64_t>(bytes));
    }
    if (table.first_byte.back() != table_at)
        file.fail("damaged chunk table: the last chunk ends at byte " +
                  std::to_string(table.first_byte.back()) + ", the table begins at " +
                  std::to_string(table_at));
    if (table.first_point.back() != point_count)
        file.fail(std::to_string(point_count) + " points; its chunks hold " +
                  std::to_string(table.first_point.back()));
    return table;
}

void check_chunk(const pointcloud::FileBytes& file, const ChunkTable& table, std::size_t chunk) {
    if (table.layers == 0)
        return;
    const std::uint64_t begin = table.first_byte[chunk] + table.record_bytes;
    const std::uint64_t end = table.first_byte[chunk + 1];
    const std::uint64_t points = table.first_point[chunk + 1] - table.first_point[chunk];
    const auto count = file.at<std::uint32_t>(begin);
    if (count != points)
        file.fail("damaged chunk " + std::to_string(chunk) + ": " + std::to_string(count) +
                  " points; its table says " + std::to_string(points));
    std::vector<std::uint32_t> sizes(table.layers);
    file.read(begin + kLayersBegin,
              {reinterpret_cast<unsigned char*>(sizes.data()), sizes.size() * kSizeBytes});
    std::uint64_t at = begin + kLayersBegin + sizes.size() * kSizeBytes;
    for (const std::uint32_t size : sizes)
        at += size;
    if (at != end)
        file.fail("damaged chunk " + std::to_string(chunk) + ": its layers end at byte " +
                  std::to_string(at) + " instead of " + std::to_string(end));
}

}  // namespace terravox::lidar
