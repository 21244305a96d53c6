#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "raytracer/tiles/tile.hpp"

namespace terravox {

/// A finished tile as bytes, for the wire and for checkpoints: its rectangle, counts, holes, samples and layers; compressed (zstd) and
/// checksummed (XXH3). The same tile gives the same bytes on every machine, but for counts.seconds.
[[nodiscard]] std::vector<std::byte> encode_tile(const TileResult& result);

/// The inverse, for bytes from anywhere. @param origin names them in messages
/// @throws Error for damage, for sizes that do not fit the rectangle, for more than kMostTile_bytes, and for values that no pixel can have
/// (colours that are not finite, shares beyond [0, 1], negative depths, no samples)
[[nodiscard]] TileResult decode_tile(std::span<const std::byte> bytes, const std::string& origin);

inline constexpr std::size_t kMostTile_bytes = std::size_t{1} << 30;  ///< of samples and layers, not compressed

/// A number for what a tile shows: samples and layers, not how they came about. Equal for equal pixels.
[[nodiscard]] std::uint64_t hash_of_pixels(const TileResult& result) noexcept;

}  // namespace terravox
