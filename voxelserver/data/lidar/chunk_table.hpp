#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/data/lidar/las_file.hpp"
#include "voxelserver/data/lidar/records.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"

namespace terravox::lidar {

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
    [[nodiscard]] std::size_t chunk_of(std::uint64_t point) const noexcept;
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
