#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "raytracer/tiles/tile.hpp"

namespace terravox::tiles {

inline constexpr std::size_t kMaxTile_bytes = std::size_t{1}
                                              << 30;  ///< of samples and layers, not compressed

/// Bytes of a tile's samples and layers, not compressed. @param tile of a rectangle that is none
/// upside down, step from 1
[[nodiscard]] std::uint64_t pixel_bytes(const RenderTile& tile, bool with_layers) noexcept;

/// A finished tile as bytes, for the wire and for checkpoints: its rectangle, counts, holes,
/// samples and layers; compressed (zstd) and checksummed (XXH3). The same tile gives the same bytes
/// on every machine, but for counts.seconds. Thread-safe, as all here.
/// @throws Error for a tile of more than kMaxTile_bytes, or whose samples or layers are not as
/// many as its rectangle asks for
[[nodiscard]] std::vector<std::byte> encode_tile(const TileResult& result);

/// The inverse, for bytes from anywhere. @param origin names them in messages
/// @throws Error for damage, for sizes that do not fit the rectangle, for more than
/// kMaxTile_bytes, and for values that no pixel can have (colours that are not finite, shares
/// beyond [0, 1], negative depths, no samples)
[[nodiscard]] TileResult decode_tile(std::span<const std::byte> bytes, const std::string& origin);

/// What encoded bytes say without their pixels.
struct TileHead {
    RenderTile tile;
    std::uint64_t pixels = 0;  ///< that each_pixel visits
    bool with_layers = false;
    std::uint32_t holes = 0;
};

/// Reads the head of encoded bytes from anywhere, with all that can be checked without taking
/// memory for pixels: version, checksum, rectangle, sizes. Who knows which tile is due compares it
/// before decode_tile. @throws Error as decode_tile
[[nodiscard]] TileHead read_tile_head(std::span<const std::byte> bytes, const std::string& origin);

/// A number for what a tile shows: samples and layers, not how they came about. Equal for equal
/// pixels: those of the same bits.
[[nodiscard]] std::uint64_t hash_of_pixels(const TileResult& result) noexcept;
/// The same of some rows of it, as of a tile of those alone. @param rows of which only y0 and y1
/// count
[[nodiscard]] std::uint64_t hash_of_pixels(const TileResult& result,
                                           const RenderTile& rows) noexcept;

}  // namespace terravox::tiles
