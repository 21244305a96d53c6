#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "raytracer/apps/pmtiles/archive_writer.hpp"
#include "raytracer/apps/pmtiles/web_area.hpp"
#include "voxelserver/serve/map/pixels.hpp"

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

    /// @return the pixels of a tile, row by row from the north-west; none where it shows nothing of
    /// the map
    /// @throws Error
    [[nodiscard]] std::vector<map::Rgba8> cut(const TileAddress& tile) const;

private:
    class Maps;
    const std::string m_attempt;
    const int m_tile_px;
    const std::string m_file;
    /// Open datasets of the map, one for each thread that cuts: GDAL's are not thread-safe.
    const std::unique_ptr<Maps> m_maps;
};

/// Metadata of the tiles, for the pages that show them.
struct MapTexts {
    std::string title;
    std::string attribution;  ///< HTML
    std::uint64_t holes = 0;  ///< boxes that could not be loaded
};

/// @throws Error where tiles of a format cannot be made here
void check_tile_format(TileFormat format);

/// Cuts a map into the tiles of all zooms of an area, and writes them as a PMTiles archive. The
/// same map gives the same bytes with any number of threads. Logs each zoom.
/// @param map as for TileCutter
/// @param area of that map
/// @param threads 0: one per core
/// @param quiet shows no progress
/// @param is_stopped asked for each tile, in any thread
/// @return how many tiles there are
/// @throws Error as TileCutter and check_tile_format(), and "interrupted"
std::uint64_t write_map_tiles(const std::filesystem::path& map, const WebArea& area,
                              const std::filesystem::path& out, TileFormat format,
                              const MapTexts& texts, int threads, bool quiet,
                              const std::function<bool()>& is_stopped);

}  // namespace terravox::pmtiles
