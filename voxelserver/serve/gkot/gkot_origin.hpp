#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/voxel/world.hpp"
#include "voxelserver/serve/gkot/gkot_request.hpp"

namespace terravox::gkot {

/// Returns boxes of level 0 within the world's bounds; nullptr: air. Never called concurrently.
/// @throws Error when a box cannot be made
using FetchBox = std::function<std::shared_ptr<const voxel::Box>(const voxel::BoxKey& key)>;

/// The content of /gkot/origin.json. Heights in metres: the lower faces of voxels.
struct Origin {
    double tmx = 0, tmy = 0;  ///< as requested
    double tmz = -1;          ///< the automatic height of y = 0; -1 in a world without any voxel
    /// Lowest and highest column top around the origin, and their difference.
    double zmin = -1;
    double zmax = -1;
    double zrange = 0;
};

/// Determines the automatic height: that of the lowest of the 64 x 64 column tops (ground, water or
/// anything on them) of the origin's box column; where that is empty, the world's lowest voxel, and
/// zmin to zmax is then the whole world. A box requested without tmz is counted from the same
/// height: passing this tmz gives the same box as omitting it.
/// @throws what `fetch` throws
[[nodiscard]] Origin find_origin(const voxel::WorldInfo& info, const OriginRequest& request,
                                 const FetchBox& fetch);

/// {"tmx":..,"tmy":..,"tmz":..,"zmin":..,"zmax":..,"zrange":..}; integers without decimals, other
/// numbers with as many as a round trip requires.
[[nodiscard]] std::string to_json(const Origin& origin);

/// The voxel that contains a point, each coordinate by floor: x = floor(E / u), z = floor(-N / u),
/// y = floor(H / voxel_m).
/// @param value finite
/// @param unit above 0
/// @return clamped to +-2^53
[[nodiscard]] std::int64_t voxel_of(double value, double unit) noexcept;

/// The smallest height that voxel_of() maps to y, so that a reported height leads back to its voxel
/// in spite of rounding.
[[nodiscard]] double height_of(std::int64_t y, double voxel_m) noexcept;

}  // namespace terravox::gkot
