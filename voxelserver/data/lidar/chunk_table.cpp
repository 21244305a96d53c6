#include "voxelserver/data/lidar/chunk_table.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace terravox::lidar {
namespace {

constexpr std::uint32_t kSymbolBits = 15;
constexpr std::uint32_t kBitBits = 13;
constexpr std::uint32_t kShortest = 1U << 24;
/// Number of high bits of a correction that are coded with a model; the rest are stored directly.
constexpr std::uint32_t kMaxHighBits = 8;

}  // namespace

RangeDecoder::SymbolModel::SymbolModel(std::uint32_t symbols)
    : m_counts(symbols, 1), m_below(symbols), m_cycle(symbols) {
    update();
    m_cycle = m_until_update = (symbols + 6) / 2;
}

void RangeDecoder::SymbolModel::update() {
    const auto symbols = static_cast<std::uint32_t>(m_counts.size());
    m_total += m_cycle;
    if (m_total > 1U << kSymbolBits) {
        m_total = 0;
        for (std::uint32_t& n : m_counts)
            m_total += n = (n + 1) / 2;
    }
    const std::uint32_t scale = 0x80000000U / m_total;
    std::uint32_t sum = 0;
    for (std::uint32_t i = 0; i < symbols; ++i) {
        m_below[i] = (scale * sum) >> (31 - kSymbolBits);
        sum += m_counts[i];
    }
    m_cycle = std::min(5 * m_cycle / 4, (symbols + 6) * 8);
    m_until_update = m_cycle;
}

void RangeDecoder::BitModel::update() {
    m_total += m_cycle;
    if (m_total > 1U << kBitBits) {
        m_total = (m_total + 1) / 2;
        m_zeros = (m_zeros + 1) / 2;
        if (m_zeros == m_total)
            ++m_total;
    }
    m_zero_share = (m_zeros * (0x80000000U / m_total)) >> (31 - kBitBits);
    m_cycle = std::min(5 * m_cycle / 4, 64U);
    m_until_update = m_cycle;
}

RangeDecoder::RangeDecoder(std::function<std::uint8_t()> next_byte)
    : m_next_byte(std::move(next_byte)) {
    for (int i = 0; i < 4; ++i)
        m_value = m_value << 8 | m_next_byte();
}

void RangeDecoder::refill() {
    // Only damaged data give a length of 0; after four bytes any length is sufficient or stays 0.
    for (int i = 0; i < 4 && m_length < kShortest; ++i) {
        m_value = m_value << 8 | m_next_byte();
        m_length <<= 8;
    }
    m_length = std::max(m_length, kShortest);
}

std::uint32_t RangeDecoder::symbol(SymbolModel& model) {
    const std::uint32_t whole = m_length;
    m_length >>= kSymbolBits;
    const std::uint32_t share = m_value / m_length;
    const auto above = std::upper_bound(model.m_below.begin() + 1, model.m_below.end(), share);
    const auto found = static_cast<std::size_t>(above - model.m_below.begin()) - 1;
    const std::uint32_t from = model.m_below[found] * m_length;
    const std::uint32_t to = above == model.m_below.end() ? whole : *above * m_length;
    m_value -= from;
    m_length = to - from;
    refill();
    ++model.m_counts[found];
    if (--model.m_until_update == 0)
        model.update();
    return static_cast<std::uint32_t>(found);
}

std::uint32_t RangeDecoder::bit(BitModel& model) {
    const std::uint32_t zero = model.m_zero_share * (m_length >> kBitBits);
    const std::uint32_t out = m_value >= zero ? 1 : 0;
    if (out == 0) {
        m_length = zero;
        ++model.m_zeros;
    } else {
        m_value -= zero;
        m_length -= zero;
    }
    refill();
    if (--model.m_until_update == 0)
        model.update();
    return out;
}

std::uint32_t RangeDecoder::bits(std::uint32_t count) {
    constexpr std::uint32_t kMaxAtOnce = 19;
    if (count > kMaxAtOnce) {
        const std::uint32_t low = bits(16);
        return bits(count - 16) << 16 | low;
    }
    m_length >>= count;
    const std::uint32_t out = m_value / m_length;
    m_value -= m_length * out;
    refill();
    return out;
}

IntegerDecoder::IntegerDecoder(RangeDecoder& decoder)
    : m_decoder(decoder), m_widths{RangeDecoder::SymbolModel(33), RangeDecoder::SymbolModel(33)} {
    for (std::uint32_t width = 1; width < 32; ++width)
        m_high_bits.emplace_back(1U << std::min(width, kMaxHighBits));
}

std::uint32_t IntegerDecoder::correction(std::size_t context) {
    // A correction of width k lies in [-(2^k - 1), -2^(k-1)] or [2^(k-1) + 1, 2^k]; width 0 is 0
    // or 1.
    const std::uint32_t width = m_decoder.symbol(m_widths[context]);
    if (width == 0)
        return m_decoder.bit(m_zero_or_one);
    if (width == 32)
        return 0x80000000U;
    std::uint32_t value = m_decoder.symbol(m_high_bits[width - 1]);
    if (width > kMaxHighBits) {
        const std::uint32_t low = width - kMaxHighBits;
        value = value << low | m_decoder.bits(low);
    }
    return value >= 1U << (width - 1) ? value + 1 : value - ((1U << width) - 1);
}

std::int32_t IntegerDecoder::next(std::int32_t predicted, std::size_t context) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(predicted) + correction(context));
}

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
                  " of " + std::to_string(file.size()) + "; fetch it again");
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

std::size_t ChunkTable::find_chunk(std::uint64_t point) const noexcept {
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
