#include "tests/bench/accuracy/reclassed.hpp"

#include "voxelserver/lidar/las_file.hpp"
#include "voxelserver/lidar/las_writer.hpp"

namespace terravox::bench {

std::vector<std::filesystem::path> reclass(const std::vector<std::filesystem::path>& files,
                                           std::uint8_t from, std::uint8_t to,
                                           const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    std::vector<std::filesystem::path> out;
    for (const auto& file : files) {
        out.push_back(folder / file.filename());
        if (std::filesystem::exists(out.back()))
            continue;  // it appears under its name when it is whole
        const auto info = lidar::read_las_info(file);
        lidar::LasWriterOptions options;
        options.point_format = info.has_colour() ? 7 : 6;
        options.scale = info.scale;
        options.offset = info.offset;
        if (info.crs)
            options.wkt = info.crs->wkt();
        lidar::LasWriter writer(out.back(), options);
        lidar::read_las_points(info, {0, info.point_count}, [&](const pointcloud::Point& p) {
            lidar::LasWritePoint copy;
            copy.x = p.x;
            copy.y = p.y;
            copy.z = p.z;
            copy.rgb = p.rgb;
            copy.intensity = p.intensity;
            copy.point_source = p.line;
            copy.return_number = p.return_number;
            copy.return_count = p.return_count;
            copy.classification = p.classification == from ? to : p.classification;
            writer.write(copy);
        });
        writer.close();
    }
    return out;
}

}  // namespace terravox::bench
