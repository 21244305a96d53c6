#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "voxelserver/data/store/chunk_index.hpp"
#include "voxelserver/data/store/square.hpp"

namespace terravox::store {

/// Version of all layouts. A file of another version is treated as absent: prepared squares are
/// remade, never converted.
inline constexpr std::uint32_t kSquareFileVersion = 1;

/// Writes a prepared square: header, patch directory, points.
/// @throws Error
void write_square(const std::filesystem::path& file, const Square& square);
/// Maps a prepared square. The header and the directory are checked at once, the points of a patch
/// when they are first requested.
/// @return nullptr when there is no such file
/// @throws Error for a damaged file or another version
[[nodiscard]] std::shared_ptr<const Square> map_square(const std::filesystem::path& file);

/// Writes a chunk index.
/// @throws Error
void write_chunks(const std::filesystem::path& file, const ChunkIndex& index);
/// Reads a chunk index.
/// @return nullopt when there is no such file
/// @throws Error as map_square()
[[nodiscard]] std::optional<ChunkIndex> read_chunks(const std::filesystem::path& file);

inline constexpr std::size_t kMaxFactsBytes = std::size_t{64} << 10;
/// Writes facts that were found out about squares, as bytes of any meaning.
/// @param facts up to kMaxFactsBytes: more is refused when it is read
/// @throws Error
void write_facts(const std::filesystem::path& file, std::string_view facts);
/// Reads facts.
/// @return nullopt when there is no such file
/// @throws Error as map_square()
[[nodiscard]] std::optional<std::string> read_facts(const std::filesystem::path& file);

}  // namespace terravox::store
