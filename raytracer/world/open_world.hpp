#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/scene/scene.hpp"

namespace terravox {

/// Opens what the command line names: the address of a voxel server, or LiDAR files and folders.
/// @param cache_dir keeps prepared LiDAR squares; empty = nothing is kept on disk
/// @throws UsageError for nothing, or a mixture; Error when it cannot be opened
[[nodiscard]] std::unique_ptr<voxel::World> open_world(const std::vector<std::string>& inputs, const std::vector<std::filesystem::path>& orthophotos,
                                                       const Scene& scene, util::StageTimes& times, const std::filesystem::path& cache_dir = {});

/// How many boxes of the world that open_world() opens are worth asking for at once: a server takes its time over each.
[[nodiscard]] int loaders_for(const std::vector<std::string>& inputs, int threads);

}  // namespace terravox
