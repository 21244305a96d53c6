#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "raytracer/apps/pmtiles/tile_address.hpp"
#include "voxelserver/serve/map/hill_shade.hpp"

namespace terravox::pmtiles {

/// Cuts a map into tiles of Web Mercator. The map is a TIFF of bytes with a CRS: red, green, blue
/// and alpha; where it has overviews, coarse tiles are made of these. Thread-safe after
/// construction.
class TileCutter {
public:
    /// @param tile_px edge of a tile
    /// @param attempt beginning of messages
    /// @throws Error for a map that cannot be read, or has other bands
    TileCutter(const std::filesystem::path& map, int tile_px, std::string attempt);
    ~TileCutter();
    TileCutter(const TileCutter&) = delete;
    TileCutter& operator=(const TileCutter&) = delete;

    /// @return the pixels of a tile, row by row from the north-west; none where it shows nothing of
    /// the map
    /// @throws Error
    [[nodiscard]] std::vector<map::Rgba8> cut(const TileAddress& tile) const;

private:
    class DatasetPool;
    const std::string m_attempt;
    const int m_tile_px;
    const std::unique_ptr<DatasetPool> m_maps;
};

}  // namespace terravox::pmtiles
