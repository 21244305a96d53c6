#pragma once

#include <memory>
#include <string>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"

namespace terravox {

/// The world of a voxel server (docs/formats.md: HTTP). Connections are kept alive, one for each thread that asks.
/// The environment variable TERRAVOX_TOKEN holds the token for a server that wants one.
/// @param url http(s)://host[:port]
/// @throws UsageError for a malformed address; Error when the server cannot be reached or speaks another version
[[nodiscard]] std::unique_ptr<voxel::World> open_remote_world(const std::string& url, util::StageTimes& times);

}  // namespace terravox
