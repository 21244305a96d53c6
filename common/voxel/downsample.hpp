#pragma once

#include <array>
#include <memory>

#include "common/voxel/box.hpp"

namespace terravox::voxel {

/// Makes the box of the next coarser level from its eight children, by the rule of coarse_voxels()
/// (coarse_rule.hpp): every coarse voxel depends only on its level and its own eight children, so
/// that boxes need no neighbours and no seams can arise.
///
/// A coarse voxel keeps attributes when one of the children that decided its material has some.
/// Where all eight are hidden, each neighbour touches four opaque voxels, and so becomes opaque or
/// shallow water: hidden voxels stay hidden, or become the rock under a bed. Cost: cells without
/// detail (air, rock) are skipped whole; the rest takes some 64-bit operations per brick and one
/// read of each stored attribute. Thread-safe.
/// @param children boxes of level n-1, index = dx + 2 dz + 4 dy for the child at (2 bx + dx, 2 by +
/// dy, 2 bz + dz); nullptr = air
/// @param key key of the result, level >= 1
/// @return nullptr when nothing is solid
[[nodiscard]] std::shared_ptr<const Box> downsample(
    const BoxKey& key, const std::array<std::shared_ptr<const Box>, 8>& children);

}  // namespace terravox::voxel
