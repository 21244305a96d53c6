#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "voxelserver/make/worlds/minecraft/chunk.hpp"
#include "voxelserver/make/worlds/minecraft/nbt.hpp"

namespace terravox::minecraft {

/// Unpacks the palette indices of a section.
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
