#pragma once

#include <memory>
#include <optional>
#include <stop_token>

#include "common/util/stage_times.hpp"
#include "voxelserver/serve/deferred_world.hpp"
#include "voxelserver/serve/options.hpp"
#include "voxelserver/store/grabber_store.hpp"
#include "voxelserver/worlds/kind/served_world.hpp"

namespace terravox::serve {

/// What a server serves.
struct OpenedForServing {
    std::unique_ptr<worlds::ServedWorld> world;
    const DeferredWorld* lidar = nullptr;      ///< `world`, where it is LiDAR data or a store
    std::optional<store::GrabberStore> store;  ///< of the grabber, where one was given
};

/// Opens the inputs of `options`: LiDAR data and stores as an DeferredWorld, all other kinds by the
/// module.
/// @param times outlives the world
/// @param stop ends the opening soon where another server is slow to answer
/// @throws UsageError for flags that do not suit the kind; Error when the world cannot be opened,
/// or it was stopped
[[nodiscard]] OpenedForServing open_for_serving(const Options& options, const Plan& plan,
                                                util::StageTimes& times,
                                                const std::stop_token& stop);

}  // namespace terravox::serve
