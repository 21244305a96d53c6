#pragma once

#include <laszip/laszip_api.h>
#include <xxhash.h>
#include <array>
#include <cstdint>
#include <memory>

#include "voxelserver/data/lidar/las_file.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"

namespace terravox::laz {

/// Reads all points of a checked file with all their fields, from first to last; LaszipReader, in
/// contrast, decompresses only the fields that voxels need. Each chunk is checked before it is
/// passed to LASzip. For use by one thread.
class PointStream {
public:
    /// @param info  from read_las_info(); must outlive this
    /// @throws Error naming the file and LASzip's reason
    explicit PointStream(const lidar::LasInfo& info);
    ~PointStream();
    PointStream(const PointStream&) = delete;
    PointStream& operator=(const PointStream&) = delete;

    /// Decodes the next point into point().
    /// @return false after the last one
    /// @throws Error when the file is damaged
    [[nodiscard]] bool next();
    [[nodiscard]] const laszip_header_struct& header() const noexcept { return *m_header; }
    [[nodiscard]] const laszip_point_struct& point() const noexcept { return *m_point; }

private:
    void require(laszip_I32 failed) const;
    /// Checks the chunk that begins with the next point, and skips empty ones before it.
    void enter_chunk();
    void close() noexcept;

    const lidar::LasInfo& m_info;
    const pointcloud::FileBytes m_bytes;
    laszip_POINTER m_reader = nullptr;
    laszip_header_struct* m_header = nullptr;
    laszip_point_struct* m_point = nullptr;
    bool m_open = false;
    std::uint64_t m_at = 0;
    std::size_t m_chunk = 0;
};

/// LASzip's last message as one line without a full stop.
[[nodiscard]] std::string laszip_message(laszip_POINTER laszip);

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
