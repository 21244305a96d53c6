#pragma once

#include <chrono>
#include <memory>
#include <stop_token>
#include <string>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"
#include "voxelserver/make/worlds/remote/http_access.hpp"

namespace terravox::worlds {

/// Opens the inputs of `options` (world_kinds.hpp). The token of a voxel server comes from
/// access_of_environment().
/// @param times receives the time of every step; outlives the world
/// @param stop of a voxel server or a remote archive: once requested, opening and every later
/// request end within about a second, by an Error; also ends reading the additions
/// @throws UsageError for no input, or for inputs of several kinds; Error when it cannot be opened
[[nodiscard]] std::unique_ptr<voxel::World> open_world(const WorldOptions& options,
                                                       util::StageTimes& times,
                                                       const std::stop_token& stop = {});

/// Opens the address of a voxel server or of a box archive.
/// @param access the origins that it may contact, and the token that it sends
/// @param timeout for each request
/// @throws UsageError for any other text; Error when it cannot be opened
[[nodiscard]] std::unique_ptr<voxel::World> open_address(const std::string& url,
                                                         const remote::HttpAccess& access,
                                                         util::StageTimes& times,
                                                         std::chrono::milliseconds timeout,
                                                         const std::stop_token& stop = {});

}  // namespace terravox::worlds
