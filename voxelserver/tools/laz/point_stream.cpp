#include "voxelserver/tools/laz/point_stream.hpp"

#include <cstring>
#include <new>

#include "voxelserver/data/lidar/chunk_table.hpp"

namespace terravox::laz {

void PointStream::enter_chunk() {
    const std::size_t before = m_chunk;
    while (m_info.chunks->empty_chunk(m_chunk))
        ++m_chunk;  // there are points left, so a chunk with points follows
    // LASzip would continue in the empty one.
    if (m_chunk != before)
        m_reader.seek(m_at);
    lidar::check_chunk(m_bytes, *m_info.chunks, m_chunk++);
}

bool PointStream::next() {
    if (m_at == m_info.point_count)
        return false;
    if (m_info.chunks && m_chunk < m_info.chunks->size() &&
        m_info.chunks->first_point[m_chunk] == m_at)
        enter_chunk();
    m_reader.next();
    ++m_at;
    return true;
}

namespace {

/// Packs the fields contiguously, without the padding and the scratch fields of LASzip's structure.
class Packed {
public:
    template <class T>
    void put(T value) noexcept {
        std::memcpy(m_bytes.data() + m_size, &value, sizeof value);
        m_size += sizeof value;
    }
    void put(const void* from, std::size_t bytes) noexcept {
        std::memcpy(m_bytes.data() + m_size, from, bytes);
        m_size += bytes;
    }
    [[nodiscard]] const unsigned char* data() const noexcept { return m_bytes.data(); }
    [[nodiscard]] std::size_t size() const noexcept { return m_size; }

private:
    std::array<unsigned char, 128> m_bytes;
    std::size_t m_size = 0;
};

void put_flags(Packed& to, const laszip_point_struct& p, bool extended) noexcept {
    to.put(static_cast<std::uint8_t>(p.scan_direction_flag | p.edge_of_flight_line << 1));
    if (extended) {
        to.put(static_cast<std::uint8_t>(p.extended_return_number | p.extended_number_of_returns
                                                                        << 4));
        to.put(static_cast<std::uint8_t>(p.extended_scanner_channel |
                                         p.extended_classification_flags << 4));
        to.put(p.extended_classification);
        to.put(p.extended_scan_angle);
        return;
    }
    to.put(static_cast<std::uint8_t>(p.return_number | p.number_of_returns << 3));
    to.put(static_cast<std::uint8_t>(p.classification | p.synthetic_flag << 5 |
                                     p.keypoint_flag << 6 | p.withheld_flag << 7));
    to.put(p.scan_angle_rank);
}

}  // namespace

PointDigest::PointDigest(int format)
    : m_extended(format >= 6),
      m_time(format != 0 && format != 2),
      m_colour(format == 2 || format == 3 || format == 5 || format == 7 || format == 8 ||
               format == 10),
      m_infrared(format == 8 || format == 10),
      m_wave(format == 4 || format == 5 || format == 9 || format == 10),
      m_state(XXH3_createState()) {
    if (!m_state)
        throw std::bad_alloc();
    XXH3_64bits_reset(m_state.get());
}

void PointDigest::add(const laszip_point_struct& p) {
    Packed packed;
    packed.put(p.X);
    packed.put(p.Y);
    packed.put(p.Z);
    packed.put(p.intensity);
    put_flags(packed, p, m_extended);
    packed.put(p.user_data);
    packed.put(p.point_source_ID);
    if (m_time)
        packed.put(&p.gps_time, sizeof p.gps_time);
    if (m_colour)
        packed.put(p.rgb, 3 * sizeof p.rgb[0]);
    if (m_infrared)
        packed.put(p.rgb[3]);
    if (m_wave)
        packed.put(p.wave_packet, sizeof p.wave_packet);
    XXH3_64bits_update(m_state.get(), packed.data(), packed.size());
    if (p.num_extra_bytes > 0)
        XXH3_64bits_update(m_state.get(), p.extra_bytes,
                           static_cast<std::size_t>(p.num_extra_bytes));
}

}  // namespace terravox::laz
