#pragma once

#include <array>
#include <cstdint>

#include "common/voxel/box.hpp"
#include "voxelserver/out/export/anvil/export_blocks.hpp"
#include "voxelserver/out/export/anvil/place.hpp"

namespace terravox::exports::anvil {

/// 16 x 16 x 16 blocks, in the order of the format: x fastest, then z, then y.
struct Section {
    static constexpr std::size_t kBlocks = 4096;
    bool uniform = true;  ///< all equal blocks[0]
    std::array<BlockId, kBlocks> blocks{};
    void fill(BlockId id) noexcept {
        uniform = true;
        blocks[0] = id;
    }
    [[nodiscard]] BlockId at(std::size_t i) const noexcept {
        return uniform ? blocks[0] : blocks[i];
    }
    [[nodiscard]] bool air() const noexcept { return uniform && blocks[0] == 0; }
    static constexpr std::size_t index(int x, int y, int z) noexcept {
        return static_cast<std::size_t>(y << 8 | z << 4 | x);
    }
};

/// Turns voxels into blocks. Not thread-safe; one for each thread.
class SectionReader {
public:
    /// The references must outlive it.
    /// @param colours whether a voxel's own colour chooses its block
    SectionReader(const ExportBlocks& blocks, const Part& part, Colours colours)
        : m_blocks(blocks), m_part(part), m_true(colours == Colours::kTrue) {}

    /// @param box nullptr: air
    /// @param cx, cy, cz which 16 voxels of the box: [0, 4), [0, 16), [0, 4)
    /// @param out receives the blocks; those outside of the part are air
    void read(const voxel::Box* box, int cx, int cy, int cz, Section& out);

private:
    [[nodiscard]] BlockId block_of(const voxel::VoxelAttr& attr);
    void cut(const voxel::BoxKey& key, int cx, int cy, int cz, Section& out) const;
    const ExportBlocks& m_blocks;
    const Part& m_part;
    const bool m_true;
    voxel::Rgb8 m_last_colour;  ///< cache of the last lookup: neighbours are often alike
    voxel::Material m_last_material = voxel::Material::kAir;
    BlockId m_last = 0;
};

}  // namespace terravox::exports::anvil
