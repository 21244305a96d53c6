#include "voxelserver/tools/laz/point_stream.hpp"

#include <algorithm>
#include <string>

#include "common/util/error.hpp"
#include "voxelserver/data/lidar/chunk_table.hpp"

namespace terravox::laz {

std::string laszip_message(laszip_POINTER laszip) {
    laszip_CHAR* text = nullptr;
    if (laszip != nullptr)
        laszip_get_error(laszip, &text);
    std::string out = text != nullptr ? text : "LASzip failed";
    while (!out.empty() && (out.back() == '\n' || out.back() == '.'))
        out.pop_back();
    std::replace(out.begin(), out.end(), '\n', ' ');
    return out;
}

PointStream::PointStream(const lidar::LasInfo& info) : m_info(info), m_bytes(info.path) {
    if (laszip_create(&m_reader) != 0)
        m_bytes.fail("LASzip could not start");
    try {
        require(laszip_decompress_selective(m_reader, laszip_DECOMPRESS_SELECTIVE_ALL));
        laszip_BOOL compressed = 0;
        require(laszip_open_reader(m_reader, info.path.c_str(), &compressed));
        m_open = true;
        require(laszip_get_header_pointer(m_reader, &m_header));
        require(laszip_get_point_pointer(m_reader, &m_point));
    } catch (...) {
        close();
        throw;
    }
}

PointStream::~PointStream() {
    close();
}

void PointStream::close() noexcept {
    if (m_open)
        laszip_close_reader(m_reader);
    laszip_destroy(m_reader);
}

void PointStream::require(laszip_I32 failed) const {
    if (failed != 0) [[unlikely]]
        m_bytes.fail(laszip_message(m_reader));
}

void PointStream::enter_chunk() {
    const std::size_t before = m_chunk;
    while (m_info.chunks->empty_chunk(m_chunk))
        ++m_chunk;  // there are points left, so a chunk with points follows
    // LASzip would continue in the empty one.
    if (m_chunk != before)
        require(laszip_seek_point(m_reader, static_cast<laszip_I64>(m_at)));
    lidar::check_chunk(m_bytes, *m_info.chunks, m_chunk++);
}

bool PointStream::next() {
    if (m_at == m_info.point_count)
        return false;
    if (m_info.chunks && m_chunk < m_info.chunks->size() &&
        m_info.chunks->first_point[m_chunk] == m_at)
        enter_chunk();
    require(laszip_read_point(m_reader));
    ++m_at;
    return true;
}

}  // namespace terravox::laz
