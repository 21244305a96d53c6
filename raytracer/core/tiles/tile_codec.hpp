#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "raytracer/core/tiles/tile.hpp"

namespace terravox::tiles {

/// Limit of a tile's samples and layers, uncompressed.
inline constexpr std::size_t kMaxTile_bytes = std::size_t{1} << 30;

/// Bytes of a tile's samples and layers, uncompressed.
/// @param tile with a rectangle that is not inverted and step >= 1
[[nodiscard]] std::uint64_t pixel_bytes(const RenderTile& tile, PixelContent content) noexcept;

/// Encodes a finished tile, for the wire and for checkpoints: its rectangle, counts, holes, samples
/// and layers; compressed (zstd) and checksummed (XXH3). The same tile gives the same bytes on
/// every machine, except for counts.seconds. Thread-safe, like all functions here.
/// @throws Error for a tile of more than kMaxTile_bytes, or when the number of samples or layers
/// does not fit its rectangle
[[nodiscard]] std::vector<std::byte> encode_tile(const TileResult& result);

/// The inverse of encode_tile, for untrusted bytes.
/// @param origin names the bytes in messages
/// @throws Error for damage, for sizes that do not fit the rectangle, for more than kMaxTile_bytes,
/// and for values that no pixel can have (non-finite colours, shares beyond [0, 1], negative
/// depths, no samples)
[[nodiscard]] TileResult decode_tile(std::span<const std::byte> bytes, const std::string& origin);

/// What encoded bytes describe, without their pixels.
struct TileHead {
    RenderTile tile;
    std::uint64_t pixels = 0;  ///< that each_pixel visits
    PixelContent content;
    std::uint32_t holes = 0;
};

/// Reads the head of untrusted bytes, with all checks that need no memory for pixels: version,
/// checksum, rectangle, sizes. A caller that knows which tile is due compares it with the head
/// before decode_tile.
/// @throws Error as decode_tile
[[nodiscard]] TileHead read_tile_head(std::span<const std::byte> bytes, const std::string& origin);

/// A hash of a tile's pixels: samples and layers, not how they were made. Equal for bitwise equal
/// pixels.
[[nodiscard]] std::uint64_t hash_of_pixels(const TileResult& result) noexcept;
/// The same of some rows of the tile, as if those were a tile.
/// @param rows of which only y0 and y1 are used
[[nodiscard]] std::uint64_t hash_of_pixels(const TileResult& result,
                                           const RenderTile& rows) noexcept;

}  // namespace terravox::tiles
