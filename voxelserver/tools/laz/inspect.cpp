#include "voxelserver/tools/laz/inspect.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/util/error.hpp"
#include "voxelserver/data/lidar/index_sources.hpp"
#include "voxelserver/data/lidar/records.hpp"
#include "voxelserver/tools/laz/point_stream.hpp"

namespace terravox::laz {
namespace {

bool is_copc(const std::filesystem::path& path) {
    const pointcloud::FileBytes file(path);
    const auto records = lidar::read_records(file);
    return std::any_of(records.begin(), records.end(), [](const lidar::VariableRecord& r) {
        return r.id == 1 && r.user == "copc";
    });
}

}  // namespace

std::string info_json(const std::filesystem::path& path) {
    const lidar::LasInfo info = lidar::read_las_info(path);
    const std::string crs = info.crs ? info.crs->name() : "";
    std::error_code none;
    const nlohmann::ordered_json json = {
        {"path", path.string()},
        {"bytes", info.file_bytes},
        {"version", "1." + std::to_string(info.version_minor)},
        {"point_format", info.point_format},
        {"compressed", info.compressed},
        {"copc", is_copc(path)},
        {"lax", std::filesystem::exists(lidar::lax_path(path), none)},
        {"point_count", info.point_count},
        {"scale", info.scale},
        {"offset", info.offset},
        {"min", info.min},
        {"max", info.max},
        {"crs",
         crs.starts_with("EPSG:") ? nlohmann::ordered_json(crs) : nlohmann::ordered_json(nullptr)},
        {"crs_name", info.crs ? nlohmann::ordered_json(crs) : nlohmann::ordered_json(nullptr)},
        {"colour", info.has_colour()},
        {"near_infrared", info.has_near_infrared()},
    };
    return json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
}

std::uint64_t check(const std::filesystem::path& path) {
    const lidar::LasInfo info = lidar::read_las_info(path);
    const pointcloud::FileBytes file(path);
    if (info.point_count == 0)
        file.fail("no points; allowed: 1 or more");
    PointStream points(info);
    std::uint64_t count = 0;
    while (points.next()) {
        const laszip_point_struct& p = points.point();
        const std::array<laszip_I32, 3> raw = {p.X, p.Y, p.Z};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double value = raw[axis] * info.scale[axis] + info.offset[axis];
            const double step = info.scale[axis];
            if (value < info.min[axis] - step || value > info.max[axis] + step) [[unlikely]]
                file.fail("point " + std::to_string(count) + " has " + "xyz"[axis] + " = " +
                          std::to_string(value) + "; allowed by its header: " +
                          std::to_string(info.min[axis]) + " to " + std::to_string(info.max[axis]));
        }
        ++count;
    }
    return count;
}

}  // namespace terravox::laz
