#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "raytracer/core/output/picture.hpp"

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

/// Where a map lies in Web Mercator, and which tiles show it.
struct WebArea {
    int tile_px = 256;               ///< edge of a tile: 256 or 512
    std::array<double, 4> bounds{};  ///< metres of EPSG:3857: west, south, east, north
    /// The coarsest zoom whose pixels are at most a tenth larger than the map's, in its middle.
    int max_zoom = 0;
    /// The zoom at which the longer side of the map still has some 64 pixels.
    int min_zoom = 0;

    /// West, south, east, north; WGS 84.
    [[nodiscard]] std::array<double, 4> bounds_deg() const noexcept;
    /// Chooses other zooms than those that suit the map.
    /// @throws UsageError unless 0 <= first <= last <= max_zoom: finer tiles would show no more
    void choose_zooms(int first, int last, const std::string& attempt);
    /// The tiles of a zoom that the map's rectangle touches, by ascending tile_id().
    [[nodiscard]] std::vector<TileAddress> tiles(int zoom) const;
    /// West, south, east, north of a tile, metres.
    [[nodiscard]] static std::array<double, 4> measure_bounds(const TileAddress& tile) noexcept;
};

/// @param placement of a map of `width` x `height` pixels
/// @param tile_px 256, or 512: a zoom then shows as much as the next one with 256
/// @param attempt beginning of messages
/// @throws UsageError for a map without a CRS, one that reaches beyond 85 degrees north or south,
/// or one on both sides of 180 degrees east
[[nodiscard]] WebArea to_web_area(const output::GeoPlacement& placement, int width, int height,
                                  int tile_px, const std::string& attempt);

}  // namespace terravox::pmtiles
