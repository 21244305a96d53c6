#include "voxelserver/data/lidar/laszip_reader.hpp"

#include <algorithm>
#include <mutex>

#include "common/util/error.hpp"

namespace terravox::lidar {
namespace {

laszip_U32 selection(WantedFields fields) {
    if (fields.all)
        return laszip_DECOMPRESS_SELECTIVE_ALL;
    laszip_U32 out = laszip_DECOMPRESS_SELECTIVE_CHANNEL_RETURNS_XY |
                     laszip_DECOMPRESS_SELECTIVE_Z | laszip_DECOMPRESS_SELECTIVE_CLASSIFICATION |
                     laszip_DECOMPRESS_SELECTIVE_FLAGS;
    if (fields.colour)
        out |= laszip_DECOMPRESS_SELECTIVE_RGB;
    if (fields.near_infrared)
        out |= laszip_DECOMPRESS_SELECTIVE_NIR;
    if (fields.echoes)
        out |= laszip_DECOMPRESS_SELECTIVE_INTENSITY | laszip_DECOMPRESS_SELECTIVE_POINT_SOURCE;
    return out;
}

}  // namespace

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

LaszipReader::LaszipReader(const std::filesystem::path& path, WantedFields fields) : m_path(path) {
    if (laszip_create(&m_reader) != 0)
        throw util::Error("read the point cloud {}: LASzip could not start", path.string());
    try {
        check(laszip_decompress_selective(m_reader, selection(fields)));
        // LASzip keeps the messages of all its readers in one unsynchronised map, and writes to it
        // for unusual headers.
        static std::mutex opening;
        const std::lock_guard lock(opening);
        laszip_BOOL compressed = 0;
        check(laszip_open_reader(m_reader, m_path.string().c_str(), &compressed));
        m_open = true;
        check(laszip_get_header_pointer(m_reader, &m_header));
        check(laszip_get_point_pointer(m_reader, &m_point));
    } catch (...) {
        close();
        throw;
    }
}

LaszipReader::~LaszipReader() {
    close();
}

void LaszipReader::close() noexcept {
    if (m_open)
        laszip_close_reader(m_reader);
    laszip_destroy(m_reader);
}

void LaszipReader::seek(std::uint64_t point) {
    check(laszip_seek_point(m_reader, static_cast<laszip_I64>(point)));
}

void LaszipReader::fail() const {
    throw util::Error("read the point cloud {}: {}", m_path.string(), laszip_message(m_reader));
}

}  // namespace terravox::lidar
