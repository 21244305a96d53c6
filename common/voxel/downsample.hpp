#pragma once

#include <array>
#include <memory>

#include "common/voxel/box.hpp"

namespace terravox::voxel {

/// Makes the box of the next coarser level from its eight children.
///
/// A coarse voxel is solid when at least four of its eight children are: ground keeps its height on average, and a sheet one
/// voxel thick (roof, wall) survives. It takes the most frequent visible material (the highest child wins a tie) and the mean of the
/// colours of that material.
/// @param children level n-1 boxes, index = dx + 2 dz + 4 dy for the child at (2 bx + dx, 2 by + dy, 2 bz + dz); nullptr = air
/// @param key of the result, level >= 1
/// @return nullptr when nothing is solid
[[nodiscard]] std::shared_ptr<const Box> downsample(const BoxKey& key, const std::array<std::shared_ptr<const Box>, 8>& children);

}  // namespace terravox::voxel
