#pragma once

#include <cstddef>

#include "voxelserver/make/worlds/kind/world_kind.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"

namespace terravox::luanti {

/// How many map blocks describe() decodes at most; where there are more, a subset spread evenly.
inline constexpr std::size_t kMaxDescribedBlocks = std::size_t{1} << 20;

/// Format, counts, extent and damage of a world, in the game's own coordinates.
/// @throws UsageError when blocks are to be counted, and as find_world_files(); Error when the map
/// cannot be read
[[nodiscard]] worlds::Description describe(const worlds::DescribeRequest& request,
                                           const minecraft::BlockTable& nodes);

}  // namespace terravox::luanti
