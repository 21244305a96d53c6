#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/voxel/box.hpp"
#include "voxelserver/make/worlds/minecraft/block_appearance_cache.hpp"
#include "voxelserver/make/worlds/minecraft/chunk.hpp"

namespace terravox::minecraft {

/// One section as voxels.
struct VoxelSection {
    /// For each column of 16 voxels (index x + 16 z), one bit a voxel, lowest first: solid and
    /// opaque; solid and see-through.
    struct Bits {
        std::array<std::uint16_t, 256> opaque;
        std::array<std::uint16_t, 256> clear;
    };
    std::vector<voxel::VoxelAttr> appearances;  ///< that occur; empty: the section is air
    /// Indices into appearances, as cells; null where there is only one.
    std::unique_ptr<std::uint8_t[]> narrow;
    std::unique_ptr<std::uint16_t[]> wide;  ///< the same, for more than 256 appearances
    std::unique_ptr<Bits> bits;             ///< unless all voxels are alike

    [[nodiscard]] bool air() const noexcept { return appearances.empty(); }
    [[nodiscard]] const voxel::VoxelAttr& at(std::size_t cell) const noexcept {
        return appearances[narrow ? narrow[cell] : wide ? wide[cell] : 0];
    }
};

/// One chunk as voxels. Immutable once made.
struct VoxelChunk {
    std::int32_t first_y = 0;            ///< y of sections[0], in sections
    std::vector<VoxelSection> sections;  ///< without gaps; empty: all air
    [[nodiscard]] const VoxelSection* section(std::int32_t y) const noexcept {
        const std::int64_t i = std::int64_t{y} - first_y;
        return i >= 0 && i < static_cast<std::int64_t>(sections.size())
                   ? &sections[static_cast<std::size_t>(i)]
                   : nullptr;
    }
    [[nodiscard]] std::size_t memory_bytes() const noexcept;
};

/// Turns blocks into voxels. Not thread-safe: one for each thread, with one shared cache.
class VoxelMaker {
public:
    explicit VoxelMaker(BlockAppearanceCache& block_appearances)
        : m_block_appearances(block_appearances), m_number_appearances(65536), m_stamps(65536) {}
    /// @throws NbtError for an invalid palette entry
    [[nodiscard]] VoxelChunk make(const ChunkBlocks& blocks);
    [[nodiscard]] VoxelSection make(const ChunkBlocks& blocks, const ChunkSection& section);

private:
    std::uint16_t appearance_index(const voxel::VoxelAttr& appearance, VoxelSection& out) const;
    void look_up_numbers(const ChunkSection& section, VoxelSection& out);

    BlockAppearanceCache& m_block_appearances;
    std::vector<voxel::VoxelAttr> m_attrs;
    std::vector<std::uint16_t> m_appearances;         ///< of each palette entry
    std::vector<std::uint16_t> m_number_appearances;  ///< of each number that has the current stamp
    std::vector<std::uint32_t> m_stamps;
    std::uint32_t m_stamp = 0;
};

/// The 4 x 4 chunks of a column of boxes with one more on every side; index (x + 1) + 6 (z + 1), x
/// and z in [-1, 5). nullptr: air.
using ChunkPatch = std::array<std::shared_ptr<const VoxelChunk>, 36>;

/// The box of the world's heights [256 by, 256 by + 256).
/// @param lift world height minus the file's, a multiple of 16
/// @return nullptr when it is all air
[[nodiscard]] std::shared_ptr<const voxel::Box> to_box(const ChunkPatch& patch,
                                                       const voxel::BoxKey& key, std::int32_t lift);

}  // namespace terravox::minecraft
