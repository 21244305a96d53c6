#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace terravox::minecraft {

/// Chunks and regions farther out are rejected: the game's own border lies at 1,875,000 chunks.
inline constexpr std::int32_t kFarthestChunk = 1 << 21;
inline constexpr std::int32_t kFarthestRegion = kFarthestChunk / 32;

enum class FileKind : std::uint8_t {
    kAnvil,     ///< a region, .mca
    kMcRegion,  ///< a region, .mcr
    kAlpha,     ///< a chunk of its own, c.X.Z.dat
    kChunk,     ///< a chunk of its own under any name, with its place stored inside
};

/// What a file is, by its path alone.
struct PlacedFile {
    FileKind kind = FileKind::kAnvil;
    std::string_view root;  ///< the folder of the world, part of the given path
    /// Folder of the dimension, from the root: "", "DIM-1", "dimensions/minecraft/the_end",
    /// "dimensions/some_pack/deep/name".
    std::string_view dimension;
    std::int32_t x = 0, z = 0;  ///< of the region or the chunk
    std::string_view refused;   ///< why it cannot be used, if it looks like one that could
};

/// @param path with '/' as separator
/// @return nullopt for files that hold no chunks. Regions lie in a folder `region` or side by side;
/// Alpha chunks two folders deep (base 36 of x mod 64, z mod 64) or side by side.
[[nodiscard]] std::optional<PlacedFile> placed_file(std::string_view path) noexcept;

/// "overworld", "nether", "end", "DIM7", "some_pack:moon", "some_pack:deep/name".
/// @param folder as PlacedFile::dimension
[[nodiscard]] std::string dimension_name(std::string_view folder);

/// Whether a file is of the database in which the Bedrock edition keeps a world's chunks.
/// @param path with '/' as separator
[[nodiscard]] bool is_bedrock_file(std::string_view path) noexcept;

/// The path up to its last '/', and the part after it.
[[nodiscard]] std::string_view find_folder(std::string_view path) noexcept;
[[nodiscard]] std::string_view to_name(std::string_view path) noexcept;
[[nodiscard]] std::string joined(std::string_view folder, std::string_view name);

/// Place of a chunk: 16 x 16 columns of voxels.
struct ChunkPlace {
    std::int32_t x = 0;
    std::int32_t z = 0;
    friend auto operator<=>(const ChunkPlace&, const ChunkPlace&) = default;
};
struct ChunkPlaceHash {
    [[nodiscard]] std::size_t operator()(const ChunkPlace& p) const noexcept {
        return (static_cast<std::size_t>(static_cast<std::uint32_t>(p.x)) << 32 |
                static_cast<std::uint32_t>(p.z)) *
               0x9E3779B97F4A7C15ULL;
    }
};

/// Whether a chunk may lie at this place.
[[nodiscard]] constexpr bool within_world(const ChunkPlace& p) noexcept {
    return p.x >= -kFarthestChunk && p.x < kFarthestChunk && p.z >= -kFarthestChunk &&
           p.z < kFarthestChunk;
}

}  // namespace terravox::minecraft
