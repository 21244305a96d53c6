#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/common/content.hpp"
#include "tests/voxelserver/data/lidar/read_points.hpp"
#include "voxelserver/data/lidar/las_file.hpp"
#include "voxelserver/data/lidar/las_writer.hpp"

namespace terravox::test {

/// The points of an uncompressed LAS file straight from its bytes: what the reader is tested
/// against.
inline std::vector<pointcloud::Point> plain_points(const std::filesystem::path& path) {
    const std::string bytes = read_content(path);
    const auto at = [&]<class T>(std::size_t offset, T value) {
        std::memcpy(&value, bytes.data() + offset, sizeof value);
        return value;
    };
    const std::size_t begin = at(96, std::uint32_t{});
    const std::size_t format = at(104, std::uint8_t{});
    const std::size_t record = at(105, std::uint16_t{});
    std::uint64_t count = at(107, std::uint32_t{});
    if (at(25, std::uint8_t{}) == 4 && at(247, std::uint64_t{}) != 0)
        count = at(247, std::uint64_t{});
    const std::size_t rgb_at[] = {0, 0, 20, 28, 0, 28, 0, 30, 30, 0, 30};
    std::vector<pointcloud::Point> out(count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t p = begin + i * record;
        double* const axes[] = {&out[i].x, &out[i].y, &out[i].z};
        for (std::size_t a = 0; a < 3; ++a)
            *axes[a] = at(p + 4 * a, std::int32_t{}) * at(131 + 8 * a, 0.0) + at(155 + 8 * a, 0.0);
        const auto returns = at(p + 14, std::uint8_t{});
        if (format >= 6) {
            out[i].return_number = returns & 15;
            out[i].return_count = returns >> 4;
            out[i].withheld = (at(p + 15, std::uint8_t{}) & 4) != 0;
            out[i].classification = at(p + 16, std::uint8_t{});
        } else {
            out[i].return_number = returns & 7;
            out[i].return_count = returns >> 3 & 7;
            out[i].withheld = (at(p + 15, std::uint8_t{}) & 0x80) != 0;
            out[i].classification = at(p + 15, std::uint8_t{}) & 31;
        }
        if (rgb_at[format] != 0)
            for (std::size_t c = 0; c < 3; ++c)
                out[i].rgb[c] = at(p + rgb_at[format] + 2 * c, std::uint16_t{});
    }
    return out;
}

inline std::vector<pointcloud::Point> all_points(const std::filesystem::path& path) {
    const auto info = lidar::read_las_info(path);
    std::vector<pointcloud::Point> out;
    lidar::read_las_points(info, {0, info.point_count},
                           [&](const pointcloud::Point& p) { out.push_back(p); });
    return out;
}

inline bool same_point(const pointcloud::Point& a, const pointcloud::Point& b) {
    return a.x == b.x && a.y == b.y && a.z == b.z && a.classification == b.classification &&
           a.return_number == b.return_number && a.return_count == b.return_count &&
           a.withheld == b.withheld && a.rgb == b.rgb;
}

/// All points as read_point_batches gives them.
inline std::vector<lidar::RawPoint> all_raw(const lidar::LasInfo& info) {
    const lidar::PointRange all{0, info.point_count};
    std::vector<lidar::RawPoint> out;
    lidar::read_point_batches(info, {&all, 1}, [&](std::span<const lidar::RawPoint> batch) {
        out.insert(out.end(), batch.begin(), batch.end());
    });
    return out;
}

/// Every byte value as a class where the format has room, in a spiral of points.
inline void write_sample(const std::filesystem::path& path, int format, std::size_t count,
                         const std::string& wkt = {}) {
    lidar::LasWriterOptions options;
    options.point_format = format;
    options.wkt = wkt;
    lidar::LasWriter writer(path, options);
    for (std::size_t i = 0; i < count; ++i) {
        lidar::LasWritePoint p;
        p.x = 462'000 + static_cast<double>(i * 37 % 10'007) / 10;
        p.y = 101'000 + static_cast<double>(i * 101 % 9'973) / 10;
        p.z = 500 + static_cast<double>(i % 700) / 7;
        p.classification = static_cast<std::uint8_t>(format >= 6 ? i % 256 : i % 32);
        p.return_count = static_cast<std::uint8_t>(1 + i % 3);
        p.return_number = static_cast<std::uint8_t>(1 + i % p.return_count);
        p.rgb = {static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(i * 3),
                 static_cast<std::uint16_t>(i * 7)};
        writer.write(p);
    }
    writer.close();
}

}  // namespace terravox::test
