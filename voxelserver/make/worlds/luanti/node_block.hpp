#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/voxel/box.hpp"
#include "voxelserver/make/worlds/luanti/map_block.hpp"
#include "voxelserver/make/worlds/luanti/node_appearances.hpp"

namespace terravox::luanti {

/// A map block as voxels, in voxel axes. Holds something other than air. Immutable once made.
struct NodeBlock {
    std::vector<voxel::VoxelAttr> appearances;  ///< that occur, at least one
    std::vector<std::uint16_t> cells;  ///< indices into appearances; empty: all are the first

    /// @param x, y, z in [0, 16); z southwards
    [[nodiscard]] const voxel::VoxelAttr& at(int x, int y, int z) const noexcept {
        return appearances[cells.empty() ? 0
                                         : cells[static_cast<std::size_t>(x + 16 * y + 256 * z)]];
    }
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        return sizeof *this + appearances.capacity() * sizeof(voxel::VoxelAttr) +
               cells.capacity() * sizeof(std::uint16_t);
    }
};

/// Turns a map block into voxels.
/// @return nullptr when all of it is air
/// @throws Error for a node whose id has no name
[[nodiscard]] std::shared_ptr<const NodeBlock> node_block_of(const MapBlock& block,
                                                             NodeAppearances& appearances);

}  // namespace terravox::luanti
