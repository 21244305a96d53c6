#pragma once

#include <chrono>
#include <memory>
#include <stop_token>
#include <string>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/world_kind.hpp"
#include "voxelserver/make/worlds/remote/http_access.hpp"
#include "voxelserver/make/worlds/remote/retry.hpp"

namespace terravox::remote {

/// The world of a voxel server (docs/formats/http.md). Connections are kept alive, one for each
/// concurrent request.
///
/// The server may be late, silent, restarting or damaged: box() and column() retry until the
/// timeout (voxelserver/make/worlds/remote/retrying_client.hpp). boxes() requests many at once;
/// those that the batch does not deliver are requested like box(), one after the other, each with
/// its own timeout (voxelserver/make/worlds/remote/batch_client.hpp). Where the server sends an
/// edition (docs/formats/http.md), every request names that of the first reply: once the server has
/// another one, boxes and columns throw voxel::ChangedError. stop() ends requests in progress
/// within about a second; so does `stop`, opening included.
/// @param url as HttpOrigin::of()
/// @param box_timeout at least 1 ms; opening waits that long too, but no longer than a minute
/// @param access the origins that it may contact, and the token that it sends there
/// @param clock of box_timeout and of the waits between tries, must outlive the world
/// @throws UsageError for a malformed address; Error when the server cannot be reached or uses
/// another version
[[nodiscard]] std::unique_ptr<voxel::World> open_remote_world(
    const std::string& url, util::StageTimes& times,
    std::chrono::milliseconds box_timeout = std::chrono::seconds(300),
    const std::stop_token& stop = {}, const HttpAccess& access = {},
    RetryClock& clock = RetryClock::steady());

}  // namespace terravox::remote

namespace terravox::worlds {

/// The http:// or https:// address of a voxel server.
extern const WorldKind kServerKind;

}  // namespace terravox::worlds
