#pragma once

#include <memory>
#include <span>
#include <stop_token>
#include <string>

#include "common/voxel/world.hpp"

namespace terravox::overlay {

/// The forms of an addition, for help and messages.
inline constexpr const char* kAdditionForms =
    "west,south,east,north,TOP (height of its top, metres), west,south,east,north,+HEIGHT (above "
    "the ground in its middle), or a GeoJSON file of polygons with the property top or height, and "
    "of points, which become street lamps";
inline constexpr std::size_t kMaxObjects = 10'000;
/// Height of a street lamp that has neither property.
inline constexpr double kLampHeight_m = 5;

/// Puts planned objects into a world.
/// @param additions each one of kAdditionForms; coordinates in the world's CRS, in voxels x0,z0,
/// x1,z1 where it has none; none: the world is returned as it is
/// @throws UsageError for another text, for objects outside of the world or without a height;
/// Error for a file that cannot be read, and as World::box(); "interrupted" when stopped
[[nodiscard]] std::unique_ptr<voxel::World> with_additions(std::unique_ptr<voxel::World> world,
                                                           std::span<const std::string> additions,
                                                           const std::stop_token& stop = {});

}  // namespace terravox::overlay
