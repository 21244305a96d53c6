#pragma once

#include <xxhash.h>
#include <array>
#include <cstdint>
#include <memory>

#include "voxelserver/data/lidar/las_file.hpp"
#include "voxelserver/data/lidar/laszip_reader.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"

namespace terravox::laz {

/// Reads all points of a checked file with all their fields, from first to last. Each chunk is
/// checked before it is passed to LASzip. For use by one thread.
class PointStream {
public:
    /// @param info  from read_las_info(); must outlive this
    /// @throws Error naming the file and LASzip's reason
    explicit PointStream(const lidar::LasInfo& info)
        : m_info(info), m_bytes(info.path), m_reader(info.path, {.all = true}) {}

    /// Decodes the next point into point().
    /// @return false after the last one
    /// @throws Error when the file is damaged
    [[nodiscard]] bool next();
    [[nodiscard]] const laszip_header_struct& header() const noexcept { return m_reader.header(); }
    [[nodiscard]] const laszip_point_struct& point() const noexcept { return m_reader.point(); }

private:
    /// Checks the chunk that begins with the next point, and skips empty ones before it.
    void enter_chunk();

    const lidar::LasInfo& m_info;
    const pointcloud::FileBytes m_bytes;
    lidar::LaszipReader m_reader;
    std::uint64_t m_at = 0;
    std::size_t m_chunk = 0;
};

/// A fingerprint of a sequence of points: equal for a file and its compressed copy if every field
/// of every point is equal.
class PointDigest {
public:
    /// @param format  0-10, which determines the fields of a point
    explicit PointDigest(int format);
    void add(const laszip_point_struct& point);
    [[nodiscard]] std::uint64_t value() const noexcept { return XXH3_64bits_digest(m_state.get()); }

private:
    struct Free {
        void operator()(XXH3_state_t* state) const noexcept { XXH3_freeState(state); }
    };
    bool m_extended;
    bool m_time;
    bool m_colour;
    bool m_infrared;
    bool m_wave;
    std::unique_ptr<XXH3_state_t, Free> m_state;
};

}  // namespace terravox::laz
