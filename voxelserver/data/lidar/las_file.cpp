#include "voxelserver/data/lidar/las_file.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <string>

#include "common/geo/proj_check.hpp"
#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "voxelserver/data/lidar/chunk_table.hpp"
#include "voxelserver/data/lidar/las_header.hpp"
#include "voxelserver/data/lidar/laszip_reader.hpp"

namespace terravox::lidar {
namespace {

template <class T>
std::span<const T> record_as(const laszip_vlr_struct& vlr) {
    return {reinterpret_cast<const T*>(vlr.data), vlr.record_length_after_header / sizeof(T)};
}

std::optional<geo::Crs> crs_of(const laszip_header_struct& header,
                               const std::filesystem::path& path) {
    std::vector<std::uint16_t> directory;
    std::vector<double> doubles;
    std::span<const char> ascii;
    std::string wkt;
    for (std::uint32_t i = 0; i < header.number_of_variable_length_records; ++i) {
        const laszip_vlr_struct& vlr = header.vlrs[i];
        if (vlr.data == nullptr ||
            std::strncmp(vlr.user_id, "LASF_Projection", sizeof vlr.user_id) != 0)
            continue;
        // Copied, since the payload of a record is not aligned.
        if (vlr.record_id == 2112)
            wkt.assign(reinterpret_cast<const char*>(vlr.data), vlr.record_length_after_header);
        if (vlr.record_id == 34735) {
            directory.resize(vlr.record_length_after_header / 2);
            std::memcpy(directory.data(), vlr.data, directory.size() * 2);
        }
        if (vlr.record_id == 34736) {
            doubles.resize(vlr.record_length_after_header / 8);
            std::memcpy(doubles.data(), vlr.data, doubles.size() * 8);
        }
        if (vlr.record_id == 34737)
            ascii = record_as<char>(vlr);
    }
    wkt.erase(std::find(wkt.begin(), wkt.end(), '\0'), wkt.end());
    if (!wkt.empty()) {
        try {
            return geo::Crs::from_wkt(wkt);
        } catch (const geo::ProjUnusableError&) {
            throw;
        } catch (const util::Error& e) {
            // Some writers store text that is not WKT in addition to valid GeoTIFF keys: then the
            // keys are used, or the user's --crs.
            util::log_info("{}: {}; its GeoTIFF keys decide, or --crs", path.string(), e.what());
        }
    }
    try {
        return geo::Crs::from_geokeys(directory, doubles, ascii);
    } catch (const geo::ProjUnusableError&) {
        throw;
    } catch (const util::Error& e) {
        util::log_info("{}: {}; --crs sets one", path.string(), e.what());
    }
    return std::nullopt;
}

}  // namespace

LasInfo read_las_info(const std::filesystem::path& path) {
    LasInfo info = check_las_header(path);
    const LaszipReader reader(path, {});
    info.crs = crs_of(reader.header(), path);
    return info;
}

std::vector<PointRange> split_by_chunk(const LasInfo& info, std::uint64_t points_per_range) {
    std::vector<PointRange> out;
    if (info.point_count == 0)
        return out;
    if (!info.seekable)
        return {{0, info.point_count}};
    if (!info.chunks) {
        const std::uint64_t step =
            std::max<std::uint64_t>(1, points_per_range / info.chunk_points) * info.chunk_points;
        for (std::uint64_t begin = 0; begin < info.point_count; begin += step)
            out.push_back({begin, std::min(begin + step, info.point_count)});
        return out;
    }
    const auto& starts = info.chunks->first_point;
    for (std::size_t i = 0; i + 1 < starts.size(); ++i) {
        if (info.chunks->empty_chunk(i))
            continue;
        if (!out.empty() && starts[i + 1] - out.back().begin <= points_per_range)
            out.back().end = starts[i + 1];
        else
            out.push_back({starts[i], starts[i + 1]});
    }
    return out;
}

void read_las_points(const LasInfo& info, PointRange range,
                     const std::function<void(const pointcloud::Point&)>& sink) {
    pointcloud::Point point;
    read_point_batches(info, {&range, 1}, [&](std::span<const RawPoint> batch) {
        for (const RawPoint& raw : batch) {
            point.x = raw.x * info.scale[0] + info.offset[0];
            point.y = raw.y * info.scale[1] + info.offset[1];
            point.z = raw.z * info.scale[2] + info.offset[2];
            point.classification = raw.classification;
            point.return_number = raw.return_number;
            point.return_count = raw.return_count;
            point.intensity = raw.intensity;
            point.line = raw.point_source;
            point.withheld = raw.withheld;
            point.overlap = raw.overlap;
            point.rgb = raw.rgb;
            sink(point);
        }
    });
}

std::uint64_t decode_only(const LasInfo& info, int threads) {
    const auto ranges = split_by_chunk(info, 200'000);
    std::atomic<std::uint64_t> count{0};
    thread::parallel_for(ranges.size(), threads, [&](std::size_t i) {
        std::uint64_t mine = 0;
        read_point_batches(
            info, {&ranges[i], 1}, [&](std::span<const RawPoint> batch) { mine += batch.size(); },
            Echoes::kSkip);
        count += mine;
    });
    return count;
}

}  // namespace terravox::lidar
