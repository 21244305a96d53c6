#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/voxel/box.hpp"
#include "voxelserver/out/export/anvil/export_blocks.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::exports::anvil {

inline constexpr int kSectionSize = 16;  ///< edge of a section, blocks; chunks are as wide
inline constexpr int kRegionSize = 512;  ///< blocks of a region file along x and z

/// The place of a part of a world in a Minecraft world.
struct Place {
    /// Voxel of the part minus offset = block. Multiples of 512 in x and z, of 16 in y.
    std::array<std::int32_t, 3> offset{};
    std::int32_t min_y = -64, height = 384;  ///< of the dimension, blocks; multiples of 16
    /// Whether the heights require a data pack.
    [[nodiscard]] bool needs_pack() const noexcept { return min_y != -64 || height != 384; }
    [[nodiscard]] std::int32_t first_section() const noexcept { return min_y / kSectionSize; }
    [[nodiscard]] std::int32_t sections() const noexcept { return height / kSectionSize; }
};

/// Places the centre of the part near x = z = 0. Heights stay as they are where they fit, else they
/// are shifted; the dimension is the usual -64 to 319 where that suffices.
/// @throws UsageError when no Minecraft world is high or wide enough, naming the level that would
/// fit
[[nodiscard]] Place find_place(const Part& part);

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
    [[nodiscard]] BlockId to_block(const voxel::VoxelAttr& attr);
    void cut(const voxel::BoxKey& key, int cx, int cy, int cz, Section& out) const;
    const ExportBlocks& m_blocks;
    const Part& m_part;
    const bool m_true;
    voxel::Rgb8 m_last_colour;  ///< cache of the last lookup: neighbours are often alike
    voxel::Material m_last_material = voxel::Material::kAir;
    BlockId m_last = 0;
};

/// The boxes above one patch of the part, as 4 x 4 chunks. Not thread-safe.
class BoxColumn {
public:
    static constexpr int kChunksAlong = voxel::kBoxSizeX / kSectionSize;

    /// Requests the boxes from the job. The references must outlive it.
    BoxColumn(Job& job, const Place& place, std::int32_t bx, std::int32_t bz);

    [[nodiscard]] bool empty() const noexcept;
    /// x of the chunk (0, 0).
    [[nodiscard]] std::int32_t chunk_x() const noexcept {
        return m_bx * kChunksAlong - m_place.offset[0] / kSectionSize;
    }
    /// z of the chunk (0, 0).
    [[nodiscard]] std::int32_t chunk_z() const noexcept {
        return m_bz * kChunksAlong - m_place.offset[2] / kSectionSize;
    }
    /// The sections of one chunk, from the lowest of the dimension up; valid until the next call.
    [[nodiscard]] std::vector<Section>& sections(int cx, int cz, SectionReader& reader);

private:
    const Place& m_place;
    const std::int32_t m_bx;
    const std::int32_t m_bz;
    std::int32_t m_first_by = 0;
    std::vector<std::shared_ptr<const voxel::Box>> m_boxes;
    std::vector<Section> m_sections;
};

/// The block above the surface at the centre of the part, or, where there is none, at the nearest
/// of some places at increasing distance.
[[nodiscard]] std::array<std::int32_t, 3> find_spawn(Job& job, const Place& place);

}  // namespace terravox::exports::anvil
