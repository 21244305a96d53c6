#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "voxelserver/make/worlds/minecraft/inflate.hpp"
#include "voxelserver/make/worlds/minecraft/source.hpp"

namespace terravox::minecraft {

/// Where the 32 x 32 chunks of a region lie in its file: index x + 32 z; sectors of 4 KiB, first <<
/// 8 | count; 0 = no such chunk.
using RegionTable = std::array<std::uint32_t, 1024>;
inline constexpr std::size_t kSectorBytes = 4096;
/// The table, and a table of times that is ignored here.
inline constexpr std::size_t kRegionHeadBytes = 2 * kSectorBytes;

/// @param head the first kRegionHeadBytes of the file, or all of it when it is shorter
/// @throws Error for a file that is empty or shorter than its head
[[nodiscard]] RegionTable read_region_table(std::span<const std::uint8_t> head);

/// A chunk as stored in its file.
struct PackedChunk {
    Compression compression = Compression::kNone;
    bool external = false;  ///< `bytes` is empty: they are in a file of their own, c.X.Z.mcc
    std::span<const std::uint8_t> bytes;
};

/// @param location of a RegionTable, not 0
/// @param buffer holds the returned bytes
/// @throws Error for a chunk that lies past the end, is longer than its sectors, or packed in an
/// unknown way
[[nodiscard]] PackedChunk read_packed(const ByteFile& region, std::uint32_t location,
                                      std::vector<std::uint8_t>& buffer);

}  // namespace terravox::minecraft
