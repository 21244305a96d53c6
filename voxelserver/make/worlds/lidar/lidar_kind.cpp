#include "voxelserver/make/worlds/lidar/lidar_kind.hpp"

#include <filesystem>
#include <string>

#include "common/util/files.hpp"
#include "common/util/log.hpp"
#include "voxelserver/data/pointcloud/formats/files.hpp"
#include "voxelserver/data/store/grabber_store.hpp"
#include "voxelserver/make/voxelize/world/lidar_world.hpp"
#include "voxelserver/make/voxelize/world/store_options.hpp"

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
    out.mark_unknown = from.mark_unknown;
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

namespace {

std::unique_ptr<voxel::World> open_with(const voxelize::LidarWorldOptions& options,
                                        util::StageTimes& times) {
    auto world = voxelize::open_lidar_world(options, times);
    const auto stats = world->stats();
    util::log_info("{} points in {} files, {} orthophotos, {}, class table {}, voxels of {} m",
                   stats.points, stats.files, stats.orthophotos, world->info().crs,
                   stats.class_table, world->info().voxel_m);
    if (stats.flight_lines > 0)
        util::log_info(
            "materials that no image shows are guessed from intensities (flight lines: {}) and the "
            "shape of roofs",
            stats.flight_lines);
    return world;
}

voxelize::LidarWorldOptions options_of_files(const WorldOptions& from) {
    voxelize::LidarWorldOptions options = lidar_options(from);
    options.files.assign(from.inputs.begin(), from.inputs.end());
    return options;
}

voxelize::LidarWorldOptions options_of_store(const WorldOptions& from) {
    voxelize::LidarWorldOptions options = lidar_options(from);
    voxelize::take_from_store(store::read_grabber_store(from.inputs.front()), options);
    return options;
}

std::unique_ptr<voxel::World> open_files(const OpenRequest& request) {
    return open_with(options_of_files(request.options), request.times);
}

std::unique_ptr<voxel::World> open_store(const OpenRequest& request) {
    return open_with(options_of_store(request.options), request.times);
}

}  // namespace

voxelize::LidarWorldOptions lidar_world_options(const WorldOptions& from) {
    return is_store(from.inputs.front()) ? options_of_store(from) : options_of_files(from);
}

constinit const WorldKind kLidarKind{
    .noun = "LiDAR data",
    .input = kLidarInputs,
    .recognises = is_lidar,
    .open = open_files,
    .flags = kLidarFlags,
    .takes_several = true,
    .takes_orthophotos = true,
    .has_squares = true,
};

constinit const WorldKind kStoreKind{
    .noun = "a store",
    .input = "the grabber's store",
    .recognises = is_store,
    .open = open_store,
    .flags = kLidarFlags,
    .takes_orthophotos = true,
    .has_squares = true,
};

}  // namespace terravox::worlds
