#pragma once

#include <xxhash.h>
#include <zstd.h>

#include "raytracer/core/tiles/tile_codec.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/raytracer/core/tiles/synthetic_tiles.hpp"

/// Encoded tiles (raytracer/core/tiles/tile_codec.cpp) as the fuzz targets change them.
namespace terravox::fuzz {

inline constexpr std::size_t kTileChecksumAt = 1;
inline constexpr std::size_t kTileChecked = 9;
inline constexpr std::size_t kTileHolesAt = 46;
inline constexpr std::uint64_t kTileVersion = 1;
inline constexpr std::size_t kTileHole_bytes = 16;

/// Bytes before the holes of a tile, all of a fixed size.
inline std::size_t tile_head_bytes() {
    static const std::size_t bytes = [] {
        tiles::RenderTile one;
        one.x1 = one.y1 = 1;
        tiles::TileResult tile = test::tile_of_chance(one, false, 1);
        tile.holes.clear();
        const auto encoded = tiles::encode_tile(tile);
        for (std::size_t at = kTileHolesAt; at + 4 <= encoded.size(); ++at) {
            std::uint32_t word = 0;
            std::memcpy(&word, &encoded[at], sizeof word);
            if (word == ZSTD_MAGICNUMBER)
                return at;
        }
        expect(false, "an encoded tile holds a zstd frame");
        return std::size_t{0};
    }();
    return bytes;
}

/// Makes the checksum of an encoded tile right that stands at [at, at + bytes).
inline void put_tile_checksum(Editable& file, std::uint64_t at, std::uint64_t bytes) {
    if (bytes < kTileChecked || !file.holds(at, bytes))
        return;
    const auto checked = file.part(at + kTileChecked, bytes - kTileChecked);
    file.put(at + kTileChecksumAt,
             XXH3_64bits_withSeed(checked.data(), checked.size(), kTileVersion));
}

}  // namespace terravox::fuzz
