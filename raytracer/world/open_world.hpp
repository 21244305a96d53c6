#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/scene/scene.hpp"

namespace terravox {

/// Opens what the command line names (recognise.hpp).
/// @param inputs of one kind; several only of LiDAR data and rasters of heights
/// @param orthophotos for LiDAR data, stores and rasters
/// @param cache_dir keeps prepared LiDAR squares; empty = nothing is kept on disk
/// @throws UsageError for nothing, or a mixture; Error when it cannot be opened
[[nodiscard]] std::unique_ptr<voxel::World> open_world(const std::vector<std::string>& inputs, const std::vector<std::filesystem::path>& orthophotos,
                                                       const Scene& scene, util::StageTimes& times, const std::filesystem::path& cache_dir = {});

}  // namespace terravox
