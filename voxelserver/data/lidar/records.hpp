#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/data/pointcloud/file_bytes.hpp"

namespace terravox::lidar {

/// A variable-length record of the header: the location of its payload.
struct VariableRecord {
    std::string user;  ///< user ID, up to 16 characters
    std::uint16_t id = 0;
    std::uint64_t at = 0;  ///< offset of the payload in the file, bytes
    std::uint16_t bytes = 0;
};

/// Reads the list of records between the header and the points.
/// @throws Error when they do not all fit there
[[nodiscard]] std::vector<VariableRecord> read_records(const pointcloud::FileBytes& file);

/// LASzip's own record, which defines the compression of the points. Ref: Isenburg, "LASzip:
/// lossless compression of LiDAR data", 2013.
struct LaszipRecord {
    enum Compressor : std::uint16_t { kPointwise = 1, kChunked = 2, kLayered = 3 };
    static constexpr std::uint32_t kVariableChunks = 0xFFFFFFFF;
    std::uint16_t compressor = 0;
    std::uint32_t chunk_points = 0;  ///< or kVariableChunks
    /// Number of separately compressed layers in a chunk of formats 6-10, whose sizes follow its
    /// first point; 0 for older formats.
    std::uint32_t layers = 0;
};

/// @return nullopt when the points are not compressed
/// @throws Error when LASzip's record does not match this point format, since LASzip would then
/// misinterpret the points
[[nodiscard]] std::optional<LaszipRecord> read_laszip_record(
    const pointcloud::FileBytes& file, const std::vector<VariableRecord>& records, int point_format,
    std::uint32_t record_bytes);

}  // namespace terravox::lidar
