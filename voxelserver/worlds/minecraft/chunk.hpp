#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "voxelserver/worlds/minecraft/chunk_place.hpp"

namespace terravox::minecraft {

inline constexpr std::int32_t kSectionVoxels = 16 * 16 * 16;
/// Sections that may hold blocks: the heights that a data pack may ask for, y = -2032 to 2031.
inline constexpr std::int32_t kLowestSection = -127, kHighestSection = 126;

/// 16 x 16 x 16 blocks. The cell at (x, y, z) is the one of index x + 16 z + 256 y.
struct ChunkSection {
    std::int32_t y = 0;    ///< its lowest voxel lies at 16 y
    bool numeric = false;  ///< cells are id * 16 + data; else places in the palette
    bool uniform = false;  ///< all cells are as the first
    std::uint32_t palette_begin = 0, palette_size = 0;  ///< of ChunkBlocks::palette
    std::array<std::uint16_t, kSectionVoxels> cells;
};

/// The blocks of one chunk as the file has them. To be used again for the next chunk: its memory is
/// kept.
struct ChunkBlocks {
    std::optional<ChunkPlace> place;           ///< what the chunk says of itself
    std::optional<std::int64_t> data_version;  ///< since 1.9
    std::string_view status;                   ///< as in the file; empty before 1.13
    bool finished = true;                      ///< the game had made all of it
    bool alpha = false;                        ///< 16 x 16 x 128 blocks in one, as before Anvil
    std::vector<std::string_view>
        palette;  ///< compounds of Name and Properties, as bytes of NBT; see palette_name()
    std::vector<std::string> oddities;  ///< what was passed over

    [[nodiscard]] std::span<const ChunkSection> sections() const noexcept {
        return {m_sections.data(), m_count};
    }  ///< by rising y, each y once

    // For the decoder.
    ChunkSection& add_section();
    void clear() noexcept;
    void sort_sections();

private:
    std::vector<ChunkSection> m_sections;
    std::size_t m_count = 0;
};

/// Reads the blocks of a chunk of any generation: numeric ids in columns of 128 (Alpha, McRegion),
/// numeric ids in sections (Anvil), palettes whose indices run across longs (1.13 to 1.15) or do
/// not (since 1.16), with `Level` around (before 1.18) or without. Sections of air only may be left
/// out.
/// @param nbt must outlive the use of `out`
/// @throws Error (NbtError) when it is no chunk, or damaged: then no block of it is to be trusted
void decode_chunk(std::span<const std::uint8_t> nbt, ChunkBlocks& out);

}  // namespace terravox::minecraft
