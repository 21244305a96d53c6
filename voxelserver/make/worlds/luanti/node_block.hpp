#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <shared_mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/voxel/box.hpp"
#include "voxelserver/make/worlds/luanti/map_block.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"

namespace terravox::luanti {

/// Material and colour of each node name; the table is searched once for each. Thread-safe. Names
/// that match no entry of the table are logged (minecraft::UnknownNames).
class NodeAppearances {
public:
    explicit NodeAppearances(minecraft::BlockTable table) : m_table(std::move(table)) {}

    [[nodiscard]] voxel::VoxelAttr of(std::string_view name);
    /// How many different names matched no entry of the table.
    [[nodiscard]] std::size_t unknown_names() const { return m_unknown.count(); }

private:
    const minecraft::BlockTable m_table;
    std::shared_mutex m_appearances_mutex;  ///< guards m_appearances
    minecraft::ByName<voxel::VoxelAttr> m_appearances;
    minecraft::UnknownNames m_unknown{"no entry of config/blocks/luanti.toml fits the node"};
};

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
[[nodiscard]] std::shared_ptr<const NodeBlock> make_node_block(const MapBlock& block,
                                                               NodeAppearances& appearances);

/// The 4 x 16 x 4 map blocks of a box, with one more on every side.
class BoxBlocks {
public:
    static constexpr int kAcross = voxel::kBoxSizeX / kBlockVoxels;
    static constexpr int kHigh = voxel::kBoxSizeY / kBlockVoxels;

    using Block = std::shared_ptr<const NodeBlock>;  ///< nullptr: air

    /// @param x, z in [-1, kAcross]
    /// @param y in [-1, kHigh]
    [[nodiscard]] Block& at(int x, int y, int z) noexcept {
        return m_blocks[compute_index(x, y, z)];
    }
    [[nodiscard]] const Block& at(int x, int y, int z) const noexcept {
        return m_blocks[compute_index(x, y, z)];
    }
    /// How many sides of the box a block lies beyond: 0 inside, 1 where it shares a face with it.
    [[nodiscard]] static int sides_passed(int x, int y, int z) noexcept {
        const auto passed = [](int at, int end) { return at < 0 || at >= end ? 1 : 0; };
        return passed(x, kAcross) + passed(y, kHigh) + passed(z, kAcross);
    }

private:
    static constexpr int kSide = kAcross + 2;
    [[nodiscard]] static std::size_t compute_index(int x, int y, int z) noexcept {
        return static_cast<std::size_t>((y + 1) * kSide * kSide + (z + 1) * kSide + x + 1);
    }
    static constexpr std::size_t kBlocks = std::size_t{kSide} * kSide * (kHigh + 2);
    std::array<Block, kBlocks> m_blocks;
};

/// @return nullptr when it is all air
[[nodiscard]] std::shared_ptr<const voxel::Box> to_box(const BoxBlocks& blocks,
                                                       const voxel::BoxKey& key);

}  // namespace terravox::luanti
