#pragma once

#include <array>
#include <string>
#include <vector>

#include "raytracer/apps/pmtiles/tile_address.hpp"
#include "raytracer/core/output/picture_info.hpp"

namespace terravox::pmtiles {

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
    [[nodiscard]] static std::array<double, 4> bounds_of(const TileAddress& tile) noexcept;
};

/// @param placement of a map of `width` x `height` pixels
/// @param tile_px 256, or 512: a zoom then shows as much as the next one with 256
/// @param attempt beginning of messages
/// @throws UsageError for a map without a CRS, one that reaches beyond 85 degrees north or south,
/// or one on both sides of 180 degrees east
[[nodiscard]] WebArea web_area_of(const output::GeoPlacement& placement, int width, int height,
                                  int tile_px, const std::string& attempt);

}  // namespace terravox::pmtiles
