#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "voxelserver/make/worlds/minecraft/nbt.hpp"
#include "voxelserver/make/worlds/minecraft/place_names.hpp"

namespace terravox::minecraft {

inline constexpr std::int32_t kSectionVoxels = 16 * 16 * 16;
/// Sections that may hold blocks: the heights that a data pack may configure, y = -2032 to 2031.
inline constexpr std::int32_t kLowestSection = -127;
inline constexpr std::int32_t kHighestSection = 126;

/// 16 x 16 x 16 blocks. The cell at (x, y, z) is the one of index x + 16 z + 256 y.
struct ChunkSection {
    std::int32_t y = 0;    ///< its lowest voxel lies at 16 y
    bool numeric = false;  ///< cells are id * 16 + data; else indices into the palette
    bool uniform = false;  ///< all cells equal the first
    std::uint32_t palette_begin = 0, palette_size = 0;  ///< of ChunkBlocks::palette
    std::array<std::uint16_t, kSectionVoxels> cells;
};

/// The blocks of one chunk as stored in the file. Reusable for the next chunk: its memory is kept.
struct ChunkBlocks {
    std::optional<ChunkPlace> place;           ///< as stored in the chunk
    std::optional<std::int64_t> data_version;  ///< since 1.9
    std::string_view status;                   ///< as in the file; empty before 1.13
    bool finished = true;                      ///< the game had generated all of it
    bool alpha = false;                        ///< 16 x 16 x 128 blocks in one, as before Anvil
    /// Compounds of Name and Properties, as bytes of NBT; see palette_name().
    std::vector<std::string_view> palette;
    std::vector<std::string> oddities;  ///< what was skipped

    /// The sections by rising y, each y once.
    [[nodiscard]] std::span<const ChunkSection> sections() const noexcept {
        return {m_sections.data(), m_count};
    }

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
/// not (since 1.16), with `Level` around (before 1.18) or without. Sections that hold only air may
/// be left out.
/// @param nbt must outlive the use of `out`
/// @throws Error (NbtError) when it is not a chunk, or damaged: none of its blocks may then be used
void decode_chunk(std::span<const std::uint8_t> nbt, ChunkBlocks& out);

/// Unpacks the palette indices of a section, before 1.18 of more bits than the palette needs, too.
/// @param data_version determines how they are packed; where the chunk has none, the length of the
/// array does
/// @throws Error when the length of the array does not match the palette, or an index lies past the
/// palette
void unpack_cells(const NbtLongs& data, std::uint32_t palette_size,
                  std::optional<std::int64_t> data_version, ChunkSection& out);

/// Numeric ids of a section.
/// @param add may be empty, data too
/// @throws Error for arrays of other lengths
void numeric_cells(std::span<const std::uint8_t> blocks, std::span<const std::uint8_t> add,
                   std::span<const std::uint8_t> data, ChunkSection& out);

/// One section of blocks in columns, 16 x 16 x 128 with y running fastest, then z.
/// @param section 0 to 7
void column_cells(std::span<const std::uint8_t> blocks, std::span<const std::uint8_t> data,
                  int section, ChunkSection& out);
inline constexpr std::size_t kColumnBlocks = 16 * 16 * 128;

}  // namespace terravox::minecraft
