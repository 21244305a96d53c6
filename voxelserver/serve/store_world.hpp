#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/http/squares.hpp"
#include "voxelserver/store/grabber_store.hpp"
#include "voxelserver/voxelize/points/square_info.hpp"

namespace terravox::serve {

/// The squares shown by the HTTP interface: those of the world, and those that the store has not
/// fetched, where they can be placed in the world.
[[nodiscard]] std::vector<http::SquareEntry> squares_of(
    std::span<const voxelize::SquareInfo> opened, const voxel::WorldInfo& world,
    const std::optional<store::GrabberStore>& store);

}  // namespace terravox::serve
