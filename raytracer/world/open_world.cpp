#include "raytracer/world/open_world.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>

#include "common/util/error.hpp"
#include "raytracer/world/remote_world.hpp"
#include "voxelserver/voxelize/lidar_world.hpp"

namespace terravox {
namespace {

bool is_url(const std::string& text) { return text.rfind("http://", 0) == 0 || text.rfind("https://", 0) == 0; }

}  // namespace

std::unique_ptr<voxel::World> open_world(const std::vector<std::string>& inputs, const std::vector<std::filesystem::path>& orthophotos, const Scene& scene,
                                         util::StageTimes& times, const std::filesystem::path& cache_dir) {
    if (inputs.empty()) throw UsageError("open the world: nothing given; allowed: LiDAR files, folders of them, or the http:// address of a voxel server");
    if (is_url(inputs.front())) {
        if (inputs.size() > 1) throw UsageError("open the world: " + std::to_string(inputs.size()) + " inputs of which one is an address; allowed: one address, or files");
        if (!orthophotos.empty()) throw UsageError("open the world " + inputs.front() + ": --ortho belongs to the server's own command line");
        return open_remote_world(inputs.front(), times, std::chrono::seconds(scene.processing.box_patience_s));
    }
    voxelize::LidarWorldOptions options;
    for (const std::string& input : inputs) {
        if (is_url(input)) throw UsageError("open the world: " + input + " beside files; allowed: one address, or files");
        options.files.emplace_back(input);
    }
    options.orthophotos = orthophotos;
    options.classes = scene.world.classes;
    options.settings = scene.world.settings;
    options.cache_dir = cache_dir;
    if (!scene.world.crs.empty()) options.crs = scene.world.crs;
    if (!scene.world.vertical_unit.empty()) options.vertical_unit = scene.world.vertical_unit;
    options.voxel_m = scene.world.voxel_m;
    options.memory_bytes = static_cast<std::size_t>(scene.world.memory_mib) << 20;
    options.threads = scene.processing.threads;
    auto world = voxelize::open_lidar_world(options, times);
    const auto stats = world->stats();
    spdlog::info("{} points in {} files, {} orthophotos, {}, voxels of {} m", stats.points, stats.files, stats.orthophotos, world->info().crs, world->info().voxel_m);
    return world;
}

int loaders_for(const std::vector<std::string>& inputs, int threads) {
    constexpr int kRemote = 8;
    return !inputs.empty() && is_url(inputs.front()) ? std::max(kRemote, threads) : threads;
}

}  // namespace terravox
