#pragma once

#include <cstdint>

namespace terravox::pmtiles {

/// A tile of Web Mercator (EPSG:3857): at each zoom the world is a square of 2^zoom x 2^zoom
/// tiles. Ref: OGC Two Dimensional Tile Matrix Set 2.0, WebMercatorQuad.
struct TileAddress {
    int zoom = 0;              ///< 0 to kMaxZoom
    std::uint32_t column = 0;  ///< from the west
    std::uint32_t row = 0;     ///< from the north
    /// A pixel of 2 mm at the equator: finer than any survey.
    static constexpr int kMaxZoom = 26;
};

/// The ID of a tile in a PMTiles archive: coarser zooms come first, and tiles of a zoom follow
/// a Hilbert curve. Ref: PMTiles specification, version 3, chapter 4.1.1 (Tile IDs).
[[nodiscard]] std::uint64_t tile_id(const TileAddress& tile) noexcept;

}  // namespace terravox::pmtiles
