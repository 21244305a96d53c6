#pragma once

#include "raytracer/core/blocks/block.hpp"

namespace terravox::blocks {

/// A box to be walked, in less memory where half of it can be saved: bricks that are full of equal
/// voxels, as in deep water, share their attributes. Then it has the same voxels, but its blob is
/// none in the box format, in which nothing is shared.
/// @param box a box of the box format, or nullptr
[[nodiscard]] Block packed(std::shared_ptr<const voxel::Box> box);

}  // namespace terravox::blocks
