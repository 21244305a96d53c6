#include "raytracer/world/open_world.hpp"

#include <spdlog/spdlog.h>

#include <charconv>
#include <chrono>

#include "common/thread/parallel.hpp"
#include "common/util/config_dir.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/voxel/archive/archive_world.hpp"
#include "raytracer/world/far_archive.hpp"
#include "raytracer/world/generated/generated_world.hpp"
#include "raytracer/world/minecraft/blocks/block_table.hpp"
#include "raytracer/world/minecraft/minecraft_world.hpp"
#include "raytracer/world/recognise.hpp"
#include "raytracer/world/relief/relief_world.hpp"
#include "raytracer/world/remote_world.hpp"
#include "voxelserver/voxelize/lidar_world.hpp"
#include "voxelserver/voxelize/store_options.hpp"

namespace terravox {
namespace {

namespace fs = std::filesystem;

/// What a world is opened from, and with.
struct Opening {
    const std::vector<std::string>& inputs;
    const std::vector<fs::path>& orthophotos;
    const Scene& scene;
    util::StageTimes& times;
    const fs::path& cache_dir;
    const std::stop_token& stop;

    [[nodiscard]] std::size_t memory_bytes() const {
        return static_cast<std::size_t>(scene.world.memory_mib) << 20;
    }
    [[nodiscard]] std::chrono::seconds patience() const {
        return std::chrono::seconds(scene.processing.box_patience_s);
    }
    [[nodiscard]] std::vector<fs::path> paths() const { return {inputs.begin(), inputs.end()}; }
};

std::unique_ptr<voxel::World> open_lidar(const Opening& o,
                                         const voxelize::LidarWorldOptions& from) {
    voxelize::LidarWorldOptions options = from;
    options.settings = o.scene.world.settings;
    options.cache_dir = o.cache_dir;
    if (!o.scene.world.vertical_unit.empty())
        options.vertical_unit = o.scene.world.vertical_unit;
    options.voxel_m = o.scene.world.voxel_m;
    options.memory_bytes = o.memory_bytes();
    options.threads = o.scene.processing.threads.value_or(0);
    auto world = voxelize::open_lidar_world(options, o.times);
    const auto stats = world->stats();
    spdlog::info("{} points in {} files, {} orthophotos, {}, voxels of {} m", stats.points,
                 stats.files, stats.orthophotos, world->info().crs, world->info().voxel_m);
    return world;
}

voxelize::LidarWorldOptions lidar_options(const Opening& o) {
    voxelize::LidarWorldOptions options;
    options.orthophotos = o.orthophotos;
    options.classes = o.scene.world.classes;
    if (!o.scene.world.crs.empty())
        options.crs = o.scene.world.crs;
    return options;
}

std::unique_ptr<voxel::World> open_files(const Opening& o) {
    voxelize::LidarWorldOptions options = lidar_options(o);
    options.files = o.paths();
    return open_lidar(o, options);
}

// The store's own class table counts unless a person names one; "asprs" is what a scene says when
// nobody did.
std::unique_ptr<voxel::World> open_store(const Opening& o) {
    voxelize::LidarWorldOptions options = lidar_options(o);
    if (options.classes == Scene::World{}.classes)
        options.classes.clear();
    voxelize::take_from_store(store::read_grabber_store(o.inputs.front()), options);
    if (options.classes.empty())
        options.classes = Scene::World{}.classes;
    return open_lidar(o, options);
}

std::unique_ptr<voxel::World> open_relief(const Opening& o) {
    relief::ReliefOptions options;
    options.rasters = util::expand_folders(o.paths(),
                                           {".tif", ".tiff", ".asc", ".img", ".vrt", ".dem", ".hgt",
                                            ".bil", ".dt2", ".dt1", ".grd", ".nc", ".xyz", ".txt"},
                                           "rasters of heights");
    options.orthophotos = o.orthophotos;
    options.voxel_m = o.scene.world.voxel_m;
    if (!o.scene.world.crs.empty())
        options.crs = o.scene.world.crs;
    const std::string& unit = o.scene.world.vertical_unit;
    if (unit == "m")
        options.height_unit_m = 1;
    else if (unit == "ft")
        options.height_unit_m = 0.3048;
    else if (unit == "us-ft")
        options.height_unit_m = 1200.0 / 3937;
    options.base_m = o.scene.world.base_m;
    options.memory_bytes = o.memory_bytes();
    options.threads = thread::thread_count(o.scene.processing.threads.value_or(0));
    return relief::open_relief_world(options);
}

std::unique_ptr<voxel::World> open_minecraft(const Opening& o) {
    minecraft::MinecraftWorldOptions options;
    options.path = o.inputs.front();
    options.dimension = o.scene.world.dimension;
    options.memory_bytes = o.memory_bytes();
    options.threads = o.scene.processing.threads.value_or(0);
    const auto blocks = minecraft::BlockTable::load(util::config_dir() / "blocks");
    auto world = minecraft::open_minecraft_world(options, blocks);
    const auto& b = world->info().bounds;
    spdlog::info("Minecraft world '{}', {} x {} x {} blocks", world->info().title,
                 b.max[0] - b.min[0], b.max[1] - b.min[1], b.max[2] - b.min[2]);
    return world;
}

std::unique_ptr<voxel::World> open_generated(const Opening& o) {
    generated::Settings settings = o.scene.generated;
    settings.voxel_m = o.scene.world.voxel_m;
    const std::string& input = o.inputs.front();
    if (const auto colon = input.find(':'); colon != std::string::npos) {
        const char *begin = input.data() + colon + 1, *end = input.data() + input.size();
        const auto read = std::from_chars(begin, end, settings.seed);
        if (begin == end || read.ec != std::errc{} || read.ptr != end)
            throw UsageError("open the world " + input + ": the seed is '" +
                             input.substr(colon + 1) + "'; allowed: 0 to 18446744073709551615");
    }
    return generated::open_generated_world(settings);
}

std::unique_ptr<voxel::World> open_as(Origin origin, const Opening& o) {
    switch (origin) {
        case Origin::kServer:
        case Origin::kFarArchive:
            return open_address(o.inputs.front(), access_of_environment(), o.times, o.patience(),
                                o.stop);
        case Origin::kArchive:
            return voxel::open_archive(voxel::archive::file_source(o.inputs.front()));
        case Origin::kGenerated: return open_generated(o);
        case Origin::kMinecraft: return open_minecraft(o);
        case Origin::kStore: return open_store(o);
        case Origin::kRelief: return open_relief(o);
        case Origin::kLidar: break;
    }
    return open_files(o);
}

}  // namespace

std::unique_ptr<voxel::World> open_address(const std::string& url, const HttpAccess& access,
                                           util::StageTimes& times,
                                           std::chrono::milliseconds patience,
                                           const std::stop_token& stop) {
    if (names_archive(url))
        return voxel::open_archive(far_archive(url, patience, stop, access));
    return open_remote_world(url, times, patience, stop, access);
}

std::unique_ptr<voxel::World> open_world(const std::vector<std::string>& inputs,
                                         const std::vector<fs::path>& orthophotos,
                                         const Scene& scene, util::StageTimes& times,
                                         const fs::path& cache_dir, const std::stop_token& stop) {
    if (inputs.empty())
        throw UsageError("open the world: nothing given; allowed: " + std::string(kOrigins));
    const Origin origin = recognise(inputs.front());
    for (const std::string& input : inputs)
        if (const Origin other = recognise(input); other != origin)
            throw UsageError("open the world: " + inputs.front() + " is " +
                             std::string(name_of(origin)) + ", " + input + " is " +
                             std::string(name_of(other)) + "; allowed: inputs of one kind");
    const bool made_of_many = origin == Origin::kLidar || origin == Origin::kRelief;
    if (inputs.size() > 1 && !made_of_many)
        throw UsageError("open the world: " + std::to_string(inputs.size()) + " inputs, of which " +
                         inputs.front() + " is " + std::string(name_of(origin)) +
                         "; allowed: one of these");
    if (!orthophotos.empty() && !made_of_many && origin != Origin::kStore)
        throw UsageError("open the world " + inputs.front() + ": --ortho with " +
                         std::string(name_of(origin)) +
                         (origin == Origin::kServer
                              ? "; it belongs to the server's own command line"
                              : "; allowed: with LiDAR data, stores and rasters of heights"));
    return open_as(origin, {inputs, orthophotos, scene, times, cache_dir, stop});
}

}  // namespace terravox
