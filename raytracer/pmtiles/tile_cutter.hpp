#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "raytracer/pmtiles/tile_address.hpp"
#include "voxelserver/map/hill_shade.hpp"

namespace terravox::pmtiles {

/// Cuts a map into tiles of the web's map. The map is a raster of bytes with a CRS: red, green,
/// blue and alpha; where it has overviews, coarse tiles are made of these. Thread-safe after
/// construction.
class TileCutter {
public:
    static constexpr int kTile_px = 256;

    /// @throws Error for a map that cannot be read, has no CRS, or lies outside of the web's map
    /// (85 degrees north or south)
    explicit TileCutter(const std::filesystem::path& map);
    ~TileCutter();
    TileCutter(const TileCutter&) = delete;
    TileCutter& operator=(const TileCutter&) = delete;

    /// The zoom whose pixels are most like the map's, in the middle of the map.
    [[nodiscard]] int max_zoom() const noexcept { return m_max_zoom; }
    /// The zoom at which the longer side of the map still has some pixels.
    [[nodiscard]] int min_zoom() const noexcept { return m_min_zoom; }
    /// West, south, east, north; WGS 84.
    [[nodiscard]] std::array<double, 4> bounds_deg() const noexcept;
    /// The tiles of a zoom that the map's rectangle touches, by ascending tile_id().
    [[nodiscard]] std::vector<TileAddress> tiles(int zoom) const;
    /// @return the pixels of a tile, row by row from the north-west; none where it shows nothing of
    /// the map
    /// @throws Error
    [[nodiscard]] std::vector<map::Rgba8> cut(const TileAddress& tile) const;

private:
    struct Maps;
    const std::unique_ptr<Maps> m_maps;
    std::array<double, 4> m_bounds{};  ///< metres of EPSG:3857: west, south, east, north
    int m_max_zoom = 0;
    int m_min_zoom = 0;
};

}  // namespace terravox::pmtiles
