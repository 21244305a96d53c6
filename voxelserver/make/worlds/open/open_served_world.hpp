#pragma once

#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "common/util/stage_times.hpp"
#include "voxelserver/make/worlds/kind/served_world.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"

namespace terravox::worlds {

/// The arguments for opening a world to be served.
struct ServeRequest {
    const WorldOptions& options;
    std::vector<std::string> flags;  ///< given on the command line, of those in WorldKind::flags
    /// The file of the program that makes boxes: another version may make other boxes of the same
    /// input.
    std::filesystem::path maker;
};

/// open_world() for a server: a world of any kind but LiDAR data, with the state of its inputs as
/// the fingerprint of every box.
///
/// The inputs are checked again after each box. Once their state has changed, this box and all
/// later ones throw ChangedError, so that no cache keeps boxes of two states under one fingerprint.
/// Where another machine reports the state (a voxel server, a web server with an archive), the
/// check is part of each request. Where it reports none, the fingerprint is a random number of this
/// process.
/// @param times receives the time of every step; outlives the world
/// @param stop ends opening and later requests of a remote world, see open_world()
/// @throws UsageError for inputs of several kinds, and for flags that do not apply; Error when it
/// cannot be opened. The world's box() and column() throw voxel::UnreachableError where another
/// machine does not answer or refuses.
[[nodiscard]] std::unique_ptr<ServedWorld> open_served_world(const ServeRequest& request,
                                                             util::StageTimes& times,
                                                             const std::stop_token& stop);

}  // namespace terravox::worlds
