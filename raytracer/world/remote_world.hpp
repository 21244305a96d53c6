#pragma once

#include <chrono>
#include <memory>
#include <stop_token>
#include <string>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/world/http_access.hpp"

namespace terravox {

/// The world of a voxel server (docs/formats.md: HTTP). Connections are kept alive, one for each
/// thread that asks.
///
/// The server may be late, silent, restarting or damaged: box() and column() ask with patience
/// (raytracer/world/patient_client.hpp). boxes() asks for many in one request; what does not come
/// that way is asked for like box(), one after the other, each with its own patience
/// (raytracer/world/batch_client.hpp).
/// stop() ends what is under way within about a second; so does `stop`, opening included.
/// @param url as HttpOrigin::of()
/// @param box_patience at least 1 ms; opening waits that long too, but no longer than a minute
/// @param access whom it may ask, and what it shows there
/// @throws UsageError for a malformed address; Error when the server cannot be reached or speaks
/// another version
[[nodiscard]] std::unique_ptr<voxel::World> open_remote_world(
    const std::string& url, util::StageTimes& times,
    std::chrono::milliseconds box_patience = std::chrono::seconds(300),
    const std::stop_token& stop = {}, const HttpAccess& access = {});

}  // namespace terravox
