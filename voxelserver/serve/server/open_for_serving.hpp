#pragma once

#include <memory>
#include <optional>
#include <stop_token>

#include "common/util/stage_times.hpp"
#include "voxelserver/data/store/grabber_store.hpp"
#include "voxelserver/make/worlds/kind/served_world.hpp"
#include "voxelserver/serve/server/deferred_world.hpp"
#include "voxelserver/serve/server/options.hpp"

namespace terravox::serve {

/// The world that a server serves, and its origin.
struct OpenedForServing {
    std::unique_ptr<worlds::ServedWorld> world;
    const DeferredWorld* lidar = nullptr;      ///< `world`, when it is LiDAR data or a store
    std::optional<store::GrabberStore> store;  ///< the grabber's store, when one was given
};

/// Opens the inputs of `options`: LiDAR data and stores as a DeferredWorld, all other kinds through
/// the module.
/// @param times outlives the world
/// @param stop cancels the opening, e.g. while another server is slow to respond
/// @throws UsageError for flags that are not valid for the kind; Error when the world cannot be
/// opened, or opening was cancelled
[[nodiscard]] OpenedForServing open_for_serving(const Options& options, const Plan& plan,
                                                util::StageTimes& times,
                                                const std::stop_token& stop);

}  // namespace terravox::serve
