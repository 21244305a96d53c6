#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/data/lidar/las_file.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"

namespace terravox::lidar {

/// A variable-length record: the location of its payload.
struct VariableRecord {
    std::string user;  ///< user ID, up to 16 characters
    std::uint16_t id = 0;
    std::uint64_t at = 0;     ///< offset of the payload in the file, bytes
    std::uint64_t bytes = 0;  ///< up to 65,535 between header and points
};

/// Reads the list of records between the header and the points.
/// @throws Error when they do not all fit there
[[nodiscard]] std::vector<VariableRecord> read_records(const pointcloud::FileBytes& file);

/// Reads the list of extended records, which LAS 1.4 and later have behind the points. Points can
/// be read without them: the list ends before the first one that does not lie in the file, with a
/// warning. At most 1,024.
[[nodiscard]] std::vector<VariableRecord> read_extended_records(const pointcloud::FileBytes& file);

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

/// Points of formats 6-10 can be stored in the older formats 1, 3, 4 and 5, so that old programs
/// can read them; the fields that these lack are stored in extra bytes of every point ("LAS 1.4
/// compatibility mode"). Ref: Isenburg, "LAS 1.4 compatibility mode for LASzip", 2014.
/// @return the offsets of these bytes, or nullopt when the file does not use this mode
/// @throws Error when its records are truncated
[[nodiscard]] std::optional<CompatibleBytes> find_compatible_bytes(
    const pointcloud::FileBytes& file, const std::vector<VariableRecord>& records, int point_format,
    std::uint32_t extra_bytes);

/// Checks the raw bytes of a LAS or LAZ file before they are passed to LASzip, which trusts counts
/// and offsets. Fills all members of LasInfo except the CRS.
/// @throws Error naming the file and the invalid value
[[nodiscard]] LasInfo check_las_header(const std::filesystem::path& path);

}  // namespace terravox::lidar
