#pragma once

#include <array>
#include <memory>

#include "common/voxel/box.hpp"

namespace terravox::voxel {

/// Makes the box of the next coarser level from its eight children, by the rule of coarse_voxels()
/// (coarse_rule.hpp): every coarse voxel is a function of its level and its own eight children and
/// of nothing else, so boxes need no neighbours and no seam can arise.
///
/// A coarse voxel keeps attributes when one of the children that it stands for has some. Where all
/// eight are hidden, the neighbours touch four opaque voxels each, and so become opaque or shallow
/// water: what is hidden stays hidden, or is the rock under a bed. Cost: cells without detail (air,
/// rock) are passed over whole; the rest is some 64-bit operations for each brick and one look at
/// each stored attribute. Thread-safe.
/// @param children level n-1 boxes, index = dx + 2 dz + 4 dy for the child at (2 bx + dx, 2 by +
/// dy, 2 bz + dz); nullptr = air
/// @param key of the result, level >= 1
/// @return nullptr when nothing is solid
[[nodiscard]] std::shared_ptr<const Box> downsample(
    const BoxKey& key, const std::array<std::shared_ptr<const Box>, 8>& children);

}  // namespace terravox::voxel
