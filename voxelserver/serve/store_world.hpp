#pragma once

#include <optional>
#include <vector>

#include "voxelserver/http/squares.hpp"
#include "voxelserver/serve/opening_world.hpp"
#include "voxelserver/store/grabber_store.hpp"

namespace terravox::serve {

/// Takes files, class table and CRS from a store, where the person named none. @param options of a world without files
/// @throws UsageError when the store has no square yet, or squares of several class tables or CRSs
void take_from_store(const store::GrabberStore& store, voxelize::LidarWorldOptions& options);

/// All different licences (attributions) of the squares, one after the other.
struct Terms {
    std::string licence, attribution;
};
[[nodiscard]] Terms terms_of(const store::GrabberStore& store);

/// What the interface shows of squares: those of the world, and those that the store has not fetched.
[[nodiscard]] std::vector<http::SquareEntry> squares_of(const OpeningWorld& world, const std::optional<store::GrabberStore>& store);

}  // namespace terravox::serve
