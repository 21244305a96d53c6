#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "voxelserver/data/lidar/las_file.hpp"
#include "voxelserver/data/lidar/las_header.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"

namespace terravox::lidar {

/// The entropy decoder of LASzip, as far as needed to read a chunk table. Damaged input gives wrong
/// symbols, never undefined behaviour. Ref: Said, "Introduction to Arithmetic Coding", HP
/// Laboratories HPL-2004-76, 2004 (adaptive models of 15 and 13 bits).
class RangeDecoder {
public:
    /// Adaptive symbol frequencies; the probabilities used for decoding are updated from them at
    /// intervals.
    class SymbolModel {
    public:
        explicit SymbolModel(std::uint32_t symbols);

    private:
        friend class RangeDecoder;
        void update();
        std::vector<std::uint32_t> m_counts;
        /// The cumulative probability of all smaller symbols, in units of 2^-15.
        std::vector<std::uint32_t> m_below;
        std::uint32_t m_total = 0;
        std::uint32_t m_cycle = 0;
        std::uint32_t m_until_update = 0;
    };
    class BitModel {
        friend class RangeDecoder;
        void update();
        std::uint32_t m_zeros = 1;
        std::uint32_t m_total = 2;
        std::uint32_t m_zero_share = 1U << 12;
        std::uint32_t m_cycle = 4;
        std::uint32_t m_until_update = 4;
    };

    /// @param next_byte  returns the next input byte; throws at the end of the input
    explicit RangeDecoder(std::function<std::uint8_t()> next_byte);
    std::uint32_t symbol(SymbolModel& model);
    std::uint32_t bit(BitModel& model);
    /// @param count  1 to 32
    std::uint32_t bits(std::uint32_t count);

private:
    void refill();
    std::function<std::uint8_t()> m_next_byte;
    std::uint32_t m_value = 0;
    std::uint32_t m_length = 0xFFFFFFFF;
};

/// LASzip's decoder of 32-bit integers as corrections of a prediction, with two contexts.
class IntegerDecoder {
public:
    explicit IntegerDecoder(RangeDecoder& decoder);
    /// @param context  0 or 1
    std::int32_t next(std::int32_t predicted, std::size_t context);

private:
    std::uint32_t correction(std::size_t context);
    RangeDecoder& m_decoder;
    std::array<RangeDecoder::SymbolModel, 2> m_widths;
    RangeDecoder::BitModel m_zero_or_one;
    std::vector<RangeDecoder::SymbolModel> m_high_bits;  ///< index: width - 1
};

/// The beginnings of the chunks of a compressed file. Chunk i holds points [first_point[i],
/// first_point[i + 1]) and bytes [first_byte[i], first_byte[i + 1]); together they hold every point
/// once. Some writers of COPC leave chunks without points, most often the last one: they are listed
/// here as in the file, and are never decompressed.
struct ChunkTable {
    std::vector<std::uint64_t> first_point, first_byte;  ///< size() + 1 elements each
    /// Bytes per point; layers per chunk, 0 for formats 0-5.
    std::uint32_t record_bytes = 0;
    std::uint32_t layers = 0;
    [[nodiscard]] std::size_t size() const noexcept { return first_point.size() - 1; }
    [[nodiscard]] bool empty_chunk(std::size_t chunk) const noexcept {
        return first_point[chunk] == first_point[chunk + 1];
    }
    /// @param point  below the number of points
    /// @return the chunk that holds it
    [[nodiscard]] std::size_t find_chunk(std::uint64_t point) const noexcept;
};

/// Reads LASzip's chunk table at the end of the file. Memory is bounded by the size of the file,
/// not by the sizes that the table claims.
/// @param points_at     offset of the compressed points, bytes
/// @param record_bytes  size of one point
/// @throws Error when the table is missing or inconsistent with these points
[[nodiscard]] ChunkTable read_chunk_table(const pointcloud::FileBytes& file,
                                          const LaszipRecord& record, std::uint64_t points_at,
                                          std::uint64_t point_count, std::uint32_t record_bytes);

/// Checks the data before the layers of a chunk (formats 6-10): its number of points, and layer
/// sizes that must add up to its size. LASzip trusts both.
/// @throws Error naming the chunk
void check_chunk(const pointcloud::FileBytes& file, const ChunkTable& table, std::size_t chunk);

}  // namespace terravox::lidar
