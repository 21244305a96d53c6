#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "common/voxel/box.hpp"
#include "voxelserver/make/worlds/luanti/block_place.hpp"
#include "voxelserver/make/worlds/luanti/node_block.hpp"

namespace terravox::luanti {

/// The 4 x 16 x 4 map blocks of a box, with one more on every side.
class BoxBlocks {
public:
    static constexpr int kAcross = voxel::kBoxSizeX / kBlockVoxels;
    static constexpr int kHigh = voxel::kBoxSizeY / kBlockVoxels;

    using Block = std::shared_ptr<const NodeBlock>;  ///< nullptr: air

    /// @param x, z in [-1, kAcross]
    /// @param y in [-1, kHigh]
    [[nodiscard]] Block& at(int x, int y, int z) noexcept { return m_blocks[index_of(x, y, z)]; }
    [[nodiscard]] const Block& at(int x, int y, int z) const noexcept {
        return m_blocks[index_of(x, y, z)];
    }
    /// How many sides of the box a block lies beyond: 0 inside, 1 where it shares a face with it.
    [[nodiscard]] static int sides_passed(int x, int y, int z) noexcept {
        const auto passed = [](int at, int end) { return at < 0 || at >= end ? 1 : 0; };
        return passed(x, kAcross) + passed(y, kHigh) + passed(z, kAcross);
    }

private:
    static constexpr int kSide = kAcross + 2;
    [[nodiscard]] static std::size_t index_of(int x, int y, int z) noexcept {
        return static_cast<std::size_t>((y + 1) * kSide * kSide + (z + 1) * kSide + x + 1);
    }
    static constexpr std::size_t kBlocks = std::size_t{kSide} * kSide * (kHigh + 2);
    std::array<Block, kBlocks> m_blocks;
};

/// @return nullptr when it is all air
[[nodiscard]] std::shared_ptr<const voxel::Box> box_of(const BoxBlocks& blocks,
                                                       const voxel::BoxKey& key);

}  // namespace terravox::luanti
