#pragma once

#include <optional>
#include <vector>

#include "voxelserver/http/squares.hpp"
#include "voxelserver/serve/deferred_world.hpp"
#include "voxelserver/store/grabber_store.hpp"

namespace terravox::serve {

/// The squares shown by the HTTP interface: those of the world, and those that the store has not
/// fetched.
[[nodiscard]] std::vector<http::SquareEntry> squares_of(
    const DeferredWorld& world, const std::optional<store::GrabberStore>& store);

}  // namespace terravox::serve
