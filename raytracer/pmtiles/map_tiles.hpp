#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "raytracer/pmtiles/archive_writer.hpp"

namespace terravox::pmtiles {

/// What a page that shows the tiles says of them.
struct MapTexts {
    std::string title;
    std::string attribution;
};

/// Cuts a map into the tiles of all zooms from its own resolution up to one at which it is small,
/// and writes them as a PMTiles archive. The same map gives the same bytes with any number of
/// threads.
/// @param map as for TileCutter
/// @param threads 0: one per core
/// @param is_stopped asked for each tile, in any thread
/// @return how many tiles there are
/// @throws Error as TileCutter, where WebP pictures are not available, and "interrupted"
std::uint64_t write_map_tiles(const std::filesystem::path& map, const std::filesystem::path& out,
                              TileFormat format, const MapTexts& texts, int threads,
                              const std::function<bool()>& is_stopped);

}  // namespace terravox::pmtiles
