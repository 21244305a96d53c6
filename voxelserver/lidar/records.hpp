#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/pointcloud/file_bytes.hpp"

namespace terravox::lidar {

/// A variable-length record of the header: where its payload lies.
struct VariableRecord {
    std::string user;  ///< up to 16 characters
    std::uint16_t id = 0;
    std::uint64_t at = 0;  ///< byte of the payload
    std::uint16_t bytes = 0;
};

/// Walks the records between the header and the points.
/// @throws Error when they do not all lie there
[[nodiscard]] std::vector<VariableRecord> read_records(const pointcloud::FileBytes& file);

/// LASzip's own record: how the points are packed. Ref: Isenburg, "LASzip: lossless compression of
/// LiDAR data", 2013.
struct LaszipRecord {
    enum Compressor : std::uint16_t { kPointwise = 1, kChunked = 2, kLayered = 3 };
    static constexpr std::uint32_t kVariableChunks = 0xFFFFFFFF;
    std::uint16_t compressor = 0;
    std::uint32_t chunk_points = 0;  ///< or kVariableChunks
    /// Separately packed layers of a chunk of formats 6-10, whose sizes stand behind its first
    /// point; 0 for older formats.
    std::uint32_t layers = 0;
};

/// @return nullopt when the points are not compressed
/// @throws Error when LASzip's record does not describe points of this format, since LASzip itself
/// would read them as something else
[[nodiscard]] std::optional<LaszipRecord> read_laszip_record(
    const pointcloud::FileBytes& file, const std::vector<VariableRecord>& records, int point_format,
    std::uint32_t record_bytes);

}  // namespace terravox::lidar
