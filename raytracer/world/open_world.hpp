#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/scene/scene.hpp"
#include "raytracer/world/http_access.hpp"

namespace terravox {

/// Opens what the command line names (recognise.hpp).
/// @param inputs of one kind; several only of LiDAR data and rasters of heights
/// @param orthophotos for LiDAR data, stores and rasters
/// @param cache_dir keeps prepared LiDAR squares; empty = nothing is kept on disk
/// @param stop of a server or an archive elsewhere: once asked, opening and whatever is fetched
/// later end within about a second, by an Error A voxel server's token: access_of_environment().
/// @throws UsageError for nothing, or a mixture; Error when it cannot be opened
[[nodiscard]] std::unique_ptr<voxel::World> open_world(
    const std::vector<std::string>& inputs, const std::vector<std::filesystem::path>& orthophotos,
    const Scene& scene, util::StageTimes& times, const std::filesystem::path& cache_dir = {},
    const std::stop_token& stop = {});

/// Opens the address of a voxel server or of a box archive.
/// @param access whom it may ask, and what it shows there @param patience for each request
/// @throws UsageError for what is no such address; Error when it cannot be opened
[[nodiscard]] std::unique_ptr<voxel::World> open_address(const std::string& url,
                                                         const HttpAccess& access,
                                                         util::StageTimes& times,
                                                         std::chrono::milliseconds patience,
                                                         const std::stop_token& stop = {});

}  // namespace terravox
