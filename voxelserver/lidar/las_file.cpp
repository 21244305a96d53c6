#include "voxelserver/lidar/las_file.hpp"

#include <laszip/laszip_api.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <mutex>
#include <string>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "voxelserver/lidar/las_header.hpp"

namespace terravox::lidar {
namespace {

/// An open LASzip reader; closes itself.
class Reader {
public:
    explicit Reader(const std::filesystem::path& path) : m_path(path) {
        if (laszip_create(&m_reader) != 0) throw Error("read the point cloud " + path.string() + ": LASzip could not start");
    }
    ~Reader() {
        if (m_open) laszip_close_reader(m_reader);
        laszip_destroy(m_reader);
    }
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;

    void open(bool selective) {
        // Coordinates, returns, class, flags and colour are all that voxels need; the rest stays compressed.
        if (selective)
            check(laszip_decompress_selective(m_reader, laszip_DECOMPRESS_SELECTIVE_CHANNEL_RETURNS_XY | laszip_DECOMPRESS_SELECTIVE_Z |
                                                            laszip_DECOMPRESS_SELECTIVE_CLASSIFICATION | laszip_DECOMPRESS_SELECTIVE_FLAGS |
                                                            laszip_DECOMPRESS_SELECTIVE_RGB));
        // LASzip keeps the messages of all its readers in one unguarded map, and writes to it when headers are odd.
        static std::mutex opening;
        const std::lock_guard lock(opening);
        laszip_BOOL compressed = 0;
        check(laszip_open_reader(m_reader, m_path.string().c_str(), &compressed));
        m_open = true;
        check(laszip_get_header_pointer(m_reader, &m_header));
        check(laszip_get_point_pointer(m_reader, &m_point));
    }
    void seek(std::uint64_t point) { check(laszip_seek_point(m_reader, static_cast<laszip_I64>(point))); }
    void next() { check(laszip_read_point(m_reader)); }
    [[nodiscard]] const laszip_header_struct& header() const noexcept { return *m_header; }
    [[nodiscard]] const laszip_point_struct& point() const noexcept { return *m_point; }

private:
    void check(laszip_I32 failed) const {
        if (failed == 0) return;
        laszip_CHAR* text = nullptr;
        laszip_get_error(m_reader, &text);
        std::string reason = text != nullptr ? text : "LASzip failed";
        while (!reason.empty() && (reason.back() == '\n' || reason.back() == '.')) reason.pop_back();
        throw Error("read the point cloud " + m_path.string() + ": " + reason);
    }
    std::filesystem::path m_path;
    laszip_POINTER m_reader = nullptr;
    laszip_header_struct* m_header = nullptr;
    laszip_point_struct* m_point = nullptr;
    bool m_open = false;
};

template <class T> std::span<const T> record_as(const laszip_vlr_struct& vlr) {
    return {reinterpret_cast<const T*>(vlr.data), vlr.record_length_after_header / sizeof(T)};
}

std::optional<geo::Crs> crs_of(const laszip_header_struct& header) {
    std::vector<std::uint16_t> directory;
    std::vector<double> doubles;
    std::span<const char> ascii;
    std::string wkt;
    for (std::uint32_t i = 0; i < header.number_of_variable_length_records; ++i) {
        const laszip_vlr_struct& vlr = header.vlrs[i];
        if (vlr.data == nullptr || std::strncmp(vlr.user_id, "LASF_Projection", sizeof vlr.user_id) != 0) continue;
        // Copied, not mapped: a record's bytes have no alignment.
        if (vlr.record_id == 2112) wkt.assign(reinterpret_cast<const char*>(vlr.data), vlr.record_length_after_header);
        if (vlr.record_id == 34735) {
            directory.resize(vlr.record_length_after_header / 2);
            std::memcpy(directory.data(), vlr.data, directory.size() * 2);
        }
        if (vlr.record_id == 34736) {
            doubles.resize(vlr.record_length_after_header / 8);
            std::memcpy(doubles.data(), vlr.data, doubles.size() * 8);
        }
        if (vlr.record_id == 34737) ascii = record_as<char>(vlr);
    }
    wkt.erase(std::find(wkt.begin(), wkt.end(), '\0'), wkt.end());
    if (!wkt.empty()) {
        try {
            return geo::Crs::from_text(wkt);
        } catch (const Error&) {
            // Some writers leave text that is no WKT beside good keys: the keys decide then, or the person does.
        }
    }
    return geo::Crs::from_geokeys(directory, doubles, ascii);
}

}  // namespace

LasInfo read_las_info(const std::filesystem::path& path) {
    LasInfo info = check_las_header(path);
    Reader reader(path);
    reader.open(false);
    info.crs = crs_of(reader.header());
    return info;
}

std::vector<PointRange> split_by_chunk(const LasInfo& info, std::uint64_t points_per_range) {
    std::vector<PointRange> out;
    if (info.point_count == 0) return out;
    if (!info.seekable) return {{0, info.point_count}};
    const std::uint64_t chunks = std::max<std::uint64_t>(1, points_per_range / info.chunk_points);
    const std::uint64_t step = chunks * info.chunk_points;
    for (std::uint64_t begin = 0; begin < info.point_count; begin += step) out.push_back({begin, std::min(begin + step, info.point_count)});
    return out;
}

void read_las_points(const LasInfo& info, PointRange range, const std::function<void(const LasPoint&)>& sink) {
    if (range.begin >= range.end) return;
    Reader reader(info.path);
    const bool extended = info.point_format >= 6;
    reader.open(extended);
    if (range.begin > 0) reader.seek(range.begin);
    const laszip_point_struct& raw = reader.point();
    const bool colour = info.has_colour();
    LasPoint point;
    for (std::uint64_t i = range.begin; i < range.end; ++i) {
        reader.next();
        point.x = raw.X * info.scale[0] + info.offset[0];
        point.y = raw.Y * info.scale[1] + info.offset[1];
        point.z = raw.Z * info.scale[2] + info.offset[2];
        if (extended) {
            point.classification = raw.extended_classification;
            point.return_number = raw.extended_return_number;
            point.return_count = raw.extended_number_of_returns;
            point.withheld = (raw.extended_classification_flags & 4) != 0;
            point.overlap = (raw.extended_classification_flags & 8) != 0;
        } else {
            point.classification = raw.classification;
            point.return_number = raw.return_number;
            point.return_count = raw.number_of_returns;
            point.withheld = raw.withheld_flag != 0;
            point.overlap = raw.classification == 12;
        }
        if (colour) point.rgb = {raw.rgb[0], raw.rgb[1], raw.rgb[2]};
        sink(point);
    }
}

std::uint64_t decode_only(const LasInfo& info, int threads) {
    const auto ranges = split_by_chunk(info, 200'000);
    std::atomic<std::uint64_t> count{0};
    thread::parallel_for(ranges.size(), threads, [&](std::size_t i) {
        std::uint64_t mine = 0;
        read_las_points(info, ranges[i], [&](const LasPoint&) { ++mine; });
        count += mine;
    });
    return count;
}

}  // namespace terravox::lidar
