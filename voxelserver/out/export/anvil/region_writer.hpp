#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "voxelserver/out/export/anvil/export_blocks.hpp"
#include "voxelserver/out/export/anvil/nbt_writer.hpp"
#include "voxelserver/out/export/anvil/section.hpp"

namespace terravox::exports::anvil {

/// Data version of Minecraft 1.21.1; later versions upgrade it when they open the world.
inline constexpr std::int32_t kDataVersion = 3955;

/// Makes chunks in the format of Minecraft 1.18 and later, without light and height maps: the game
/// computes them (isLightOn = 0). Not thread-safe.
class ChunkWriter {
public:
    ChunkWriter(const ExportBlocks& blocks, const Place& place);

    /// @param x, z of the chunk: block >> 4
    /// @param sections from the lowest of the dimension up; plants are changed to their rooted
    /// block where the game lets them stand
    /// @return the chunk as NBT, empty when it holds nothing but air
    [[nodiscard]] std::string chunk(std::int32_t x, std::int32_t z, std::vector<Section>& sections);

    /// Voxels written so far, without air.
    [[nodiscard]] std::uint64_t voxels() const noexcept { return m_voxels; }

private:
    void root_plants(std::vector<Section>& sections) const;
    [[nodiscard]] std::uint64_t survey_sections(const std::vector<Section>& sections);
    void put_blocks(const Section& section);
    void put_state(BlockId id);
    [[nodiscard]] std::string biomes() const;

    const ExportBlocks& m_blocks;
    const Place m_place;
    std::vector<bool> m_rooted_above;  ///< by block: a plant stands on it
    std::vector<BlockId> m_rooted;     ///< by block: what it becomes there
    /// By block, while a section is written: 0 = not in the palette, else its place + 1.
    std::vector<std::uint16_t> m_place_in_palette;
    std::array<voxel::Material, 256> m_top{};  ///< of each column of the chunk: its highest block
    NbtWriter m_nbt;
    std::uint64_t m_voxels = 0;
};

/// The biome of ground with such a surface: it tints grass and leaves, and determines snowfall.
/// @param tops highest blocks of 4 x 4 columns, kAir for empty ones
[[nodiscard]] std::string_view choose_biome(std::span<const voxel::Material, 16> tops) noexcept;

/// Compresses as the game does. Not thread-safe; the output depends on the input alone.
class Compressor {
public:
    Compressor();
    ~Compressor();
    Compressor(const Compressor&) = delete;
    Compressor& operator=(const Compressor&) = delete;
    [[nodiscard]] std::string zlib(std::string_view bytes);
    [[nodiscard]] std::string gzip(std::string_view bytes);

private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

/// A chunk as it goes into a region file.
struct PackedChunk {
    std::int32_t x = 0, z = 0;  ///< of the chunk
    std::string zlib;           ///< its NBT, compressed; never empty
};

/// Writes r.<rx>.<rz>.mca, whole or not at all; chunks that are too long for it go to c.<x>.<z>.mcc
/// next to it, written before.
/// @param chunks of this region, each place once; their order does not matter
/// @return bytes written
/// @throws Error when a file cannot be written
std::uint64_t write_region(const std::filesystem::path& folder, std::int32_t rx, std::int32_t rz,
                           std::vector<PackedChunk> chunks);

}  // namespace terravox::exports::anvil
