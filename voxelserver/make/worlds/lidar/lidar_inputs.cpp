#include "voxelserver/make/worlds/lidar/lidar_inputs.hpp"

#include <filesystem>

#include "common/util/files.hpp"
#include "voxelserver/data/pointcloud/formats/files.hpp"

namespace terravox::worlds {

namespace fs = std::filesystem;

bool is_lidar(const std::string& input) {
    std::error_code failed;
    if (!fs::is_directory(input, failed))
        return pointcloud::is_point_file(input);
    return util::any_file(input, pointcloud::is_point_file_of_folder);
}

bool is_store(const std::string& input) {
    std::error_code failed;
    return fs::exists(fs::path(input) / "fishnet.gpkg", failed);
}

voxelize::LidarWorldOptions lidar_options(const WorldOptions& from) {
    voxelize::LidarWorldOptions out;
    out.title = from.title;
    out.orthophotos = from.orthophotos;
    out.classes = from.classes;
    out.settings = from.settings;
    out.steps = from.steps;
    out.photo = from.photo;
    if (!from.crs.empty())
        out.crs = from.crs;
    if (!from.vertical_unit.empty())
        out.vertical_unit = from.vertical_unit;
    out.voxel_m = from.voxel_m;
    out.memory_bytes = from.memory_bytes;
    out.threads = from.threads;
    out.cache_dir = from.cache_dir;
    out.cache_bytes = from.cache_bytes;
    out.left_out = from.left_out;
    out.known_squares = from.known_squares;
    out.chunk_indices = from.chunk_indices;
    out.reads_chunk_indices = from.reads_chunk_indices;
    return out;
}

}  // namespace terravox::worlds
